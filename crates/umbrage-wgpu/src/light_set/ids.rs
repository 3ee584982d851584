//! Ids of the parts of a set. Each contains the number of its set, so that other sets refuse it.

use slotmap::new_key_type;
use std::sync::atomic::{AtomicUsize, Ordering};
use umbrage_core::Invalid;

/// Number of a set, unique within the process.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub(crate) struct SetNumber(usize);

impl SetNumber {
    /// Returns the number of a new set.
    pub(crate) fn next() -> Self {
        static NEXT: AtomicUsize = AtomicUsize::new(0);
        Self(NEXT.fetch_add(1, Ordering::Relaxed))
    }
}

/// Declares an id, and the key in the maps of its set.
macro_rules! id {
    ($(#[$doc:meta])* $id:ident, $key:ident, $what:literal) => {
        new_key_type! {
            /// Key in the maps of a set.
            pub(crate) struct $key;
        }

        $(#[$doc])*
        #[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
        pub struct $id {
            set: SetNumber,
            key: $key,
        }

        impl $id {
            pub(crate) fn new(set: SetNumber, key: $key) -> Self {
                Self { set, key }
            }

            /// Returns the key in a set.
            ///
            /// Errors if the id is that of another set.
            pub(crate) fn key_in(self, set: SetNumber) -> Result<$key, Invalid> {
                if self.set == set {
                    return Ok(self.key);
                }
                let help = "use an id that this set returned";
                Err(Invalid::new($what, "is in another light set", help))
            }
        }
    };
}

id! {
    /// Identifies a light of a [`LightSet`](crate::LightSet).
    LightId, LightKey, "light"
}
id! {
    /// Identifies a mesh of a [`LightSet`](crate::LightSet).
    MeshId, MeshKey, "mesh"
}
id! {
    /// Identifies a caster of a [`LightSet`](crate::LightSet).
    CasterId, CasterKey, "caster"
}
id! {
    /// Identifies a caster of a [`LightSet`](crate::LightSet) that the program draws itself.
    OwnCasterId, OwnCasterKey, "own caster"
}
