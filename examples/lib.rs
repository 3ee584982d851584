//! Code that several examples and tests share: a small renderer, techniques written like those of a
//! user of the library, and the artefacts of the documentation.

/// Techniques of other renderers that the library doesn't have. `docs/others.md` compares them.
pub mod rivals {
    pub mod contact;
    pub mod panes;
}
pub mod failures;
pub mod judge;
pub mod light_set;
#[path = "add_shadows/renderer.rs"]
pub mod renderer;
#[path = "add_shadows/set.rs"]
pub mod set;
pub mod sheet;
pub mod variance;
