//! Code that several examples share, and that tests run: a small renderer, techniques written as a
//! user of the library would, and the artefacts that the documentation shows.

/// Techniques that other renderers have and the library has not. `docs/others.md` compares them.
pub mod beside {
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
