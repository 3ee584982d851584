//! Rows of tables, computed in advance or on first use.

use std::{
    fmt::{Debug, Formatter},
    sync::{Arc, OnceLock},
};

type SharedRows = Arc<[[u32; 4]]>;
type Make = dyn Fn() -> SharedRows + Send + Sync;

/// Rows of a table. Clones share them.
#[derive(Clone)]
pub struct TableRows(Content);

#[derive(Clone)]
enum Content {
    Made(SharedRows),
    OnFirstUse(Arc<Later>),
}

struct Later {
    made: OnceLock<SharedRows>,
    make: Box<Make>,
}

impl Later {
    /// Computes rows without a lock. The computation may run on a thread pool, where a waiting
    /// thread may be given work that requests the same rows. If several threads compute them, all
    /// use the first result.
    fn get(&self) -> &SharedRows {
        if let Some(rows) = self.made.get() {
            return rows;
        }
        let rows = (self.make)();
        self.made.get_or_init(|| rows)
    }
}

impl TableRows {
    /// Returns rows that `make` computes on first use, for tables that not every backend reads.
    /// Concurrent first calls may each run it; all get the same rows.
    pub fn on_first_use(make: impl Fn() -> Arc<[[u32; 4]]> + Send + Sync + 'static) -> Self {
        Self(Content::OnFirstUse(Arc::new(Later {
            made: OnceLock::new(),
            make: Box::new(make),
        })))
    }

    /// Returns the rows; computes them on first use.
    pub fn get(&self) -> &Arc<[[u32; 4]]> {
        match &self.0 {
            Content::Made(rows) => rows,
            Content::OnFirstUse(later) => later.get(),
        }
    }

    /// Returns the rows if they are computed already.
    pub fn made_rows(&self) -> Option<&Arc<[[u32; 4]]>> {
        match &self.0 {
            Content::Made(rows) => Some(rows),
            Content::OnFirstUse(later) => later.made.get(),
        }
    }
}

impl From<Arc<[[u32; 4]]>> for TableRows {
    fn from(rows: Arc<[[u32; 4]]>) -> Self {
        Self(Content::Made(rows))
    }
}

impl From<Vec<[u32; 4]>> for TableRows {
    fn from(rows: Vec<[u32; 4]>) -> Self {
        Self(Content::Made(rows.into()))
    }
}

impl Debug for TableRows {
    fn fmt(&self, f: &mut Formatter<'_>) -> std::fmt::Result {
        match self.made_rows() {
            Some(rows) => write!(f, "{} rows", rows.len()),
            None => f.write_str("rows that are not computed yet"),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::atomic::{AtomicU32, Ordering};

    #[test]
    fn rows_are_made_once_and_when_requested() {
        let calls = Arc::new(AtomicU32::new(0));
        let counted = calls.clone();
        let rows = TableRows::on_first_use(move || {
            counted.fetch_add(1, Ordering::Relaxed);
            Arc::new([[7; 4]])
        });
        let copy = rows.clone();
        assert!(rows.made_rows().is_none());
        assert_eq!(format!("{rows:?}"), "rows that are not computed yet");
        assert_eq!(calls.load(Ordering::Relaxed), 0);
        assert_eq!(copy.get()[0], [7; 4]);
        assert!(Arc::ptr_eq(rows.get(), copy.get()));
        assert_eq!(calls.load(Ordering::Relaxed), 1);
        assert_eq!(format!("{rows:?}"), "1 rows");
        assert!(TableRows::from(rows.get().clone()).made_rows().is_some());
    }
}
