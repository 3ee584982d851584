//! Rows of tables, made beforehand or when somebody asks for them.

use std::{
    fmt::{Debug, Formatter},
    sync::{Arc, LazyLock},
};

type Rows = Arc<[[u32; 4]]>;
type Make = Box<dyn FnOnce() -> Rows + Send>;

/// Rows of a table. Copies share them.
#[derive(Clone)]
pub struct TableRows(Content);

#[derive(Clone)]
enum Content {
    Made(Rows),
    OnFirstUse(Arc<LazyLock<Rows, Make>>),
}

impl TableRows {
    /// Returns rows that `make` makes when they are asked for, once: for tables that not every backend reads.
    pub fn on_first_use(make: impl FnOnce() -> Arc<[[u32; 4]]> + Send + 'static) -> Self {
        let make: Make = Box::new(make);
        Self(Content::OnFirstUse(Arc::new(LazyLock::new(make))))
    }

    /// Returns the rows; they are made now if nobody asked before.
    pub fn get(&self) -> &Arc<[[u32; 4]]> {
        match &self.0 {
            Content::Made(rows) => rows,
            Content::OnFirstUse(rows) => LazyLock::force(rows),
        }
    }

    /// Returns the rows if they were made.
    pub fn made(&self) -> Option<&Arc<[[u32; 4]]>> {
        match &self.0 {
            Content::Made(rows) => Some(rows),
            Content::OnFirstUse(rows) => LazyLock::get(rows),
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
        match self.made() {
            Some(rows) => write!(f, "{} rows", rows.len()),
            None => f.write_str("rows that nobody asked for yet"),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::atomic::{AtomicU32, Ordering};

    #[test]
    fn rows_are_made_once_and_when_asked_for() {
        let calls = Arc::new(AtomicU32::new(0));
        let counted = calls.clone();
        let rows = TableRows::on_first_use(move || {
            counted.fetch_add(1, Ordering::Relaxed);
            Arc::new([[7; 4]])
        });
        let copy = rows.clone();
        assert!(rows.made().is_none());
        assert_eq!(format!("{rows:?}"), "rows that nobody asked for yet");
        assert_eq!(calls.load(Ordering::Relaxed), 0);
        assert_eq!(copy.get()[0], [7; 4]);
        assert!(Arc::ptr_eq(rows.get(), copy.get()));
        assert_eq!(calls.load(Ordering::Relaxed), 1);
        assert_eq!(format!("{rows:?}"), "1 rows");
        assert!(TableRows::from(rows.get().clone()).made().is_some());
    }
}
