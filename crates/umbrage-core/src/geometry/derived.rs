//! Values derived from a geometry's triangles and cached by type.

use std::{
    any::{Any, TypeId},
    collections::HashMap,
    sync::{Arc, Mutex, PoisonError},
};

type Anything = Arc<dyn Any + Send + Sync>;

/// Values of different types, at most one per type. A clone contains the values computed so far.
#[derive(Default)]
pub(super) struct Derived {
    values: Mutex<HashMap<TypeId, Anything>>,
}

impl Derived {
    /// Returns the value of a type; `make` computes it on first use. Concurrent first calls may
    /// each compute it; all return the same value.
    pub(super) fn get_or_make<T: Any + Send + Sync>(&self, make: impl FnOnce() -> T) -> Arc<T> {
        if let Some(known) = self.get() {
            return known;
        }
        // Compute without the lock: `make` may take seconds and may call this for other types.
        let made = Arc::new(make());
        let mut values = self.lock();
        values
            .entry(TypeId::of::<T>())
            .or_insert_with(|| made.clone());
        drop(values);
        // Another thread may have stored its value first.
        self.get().unwrap_or(made)
    }

    fn get<T: Any + Send + Sync>(&self) -> Option<Arc<T>> {
        let value = self.lock().get(&TypeId::of::<T>())?.clone();
        value.downcast().ok()
    }

    fn lock(&self) -> std::sync::MutexGuard<'_, HashMap<TypeId, Anything>> {
        // A panic in another thread leaves no partial value.
        self.values.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Clone for Derived {
    fn clone(&self) -> Self {
        Self {
            values: Mutex::new(self.lock().clone()),
        }
    }
}

impl std::fmt::Debug for Derived {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{} derived values", self.lock().len())
    }
}

#[cfg(test)]
mod tests {
    use super::Derived;

    #[test]
    fn each_type_is_made_once() {
        let derived = Derived::default();
        assert_eq!(*derived.get_or_make(|| 1_u32), 1);
        assert_eq!(*derived.get_or_make(|| 2_u32), 1, "the cached value");
        assert_eq!(*derived.get_or_make(|| 3_u64), 3, "another type");
        // `make` may use another derived value.
        let length = derived.get_or_make(|| derived.get_or_make(|| "four").len());
        assert_eq!(*length, 4);
        let clone = derived.clone();
        assert_eq!(*clone.get_or_make(|| 5_u32), 1);
    }
}
