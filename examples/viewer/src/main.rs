//! A window to see shadows in: drag the lights, compare techniques side by side, measure them against rays.

mod app;
mod beside;
mod bookmarks;
mod camera;
mod device;
mod drops;
mod focus;
mod gizmo;
mod keys;
mod lights;
mod loading;
mod measure;
#[cfg(not(target_arch = "wasm32"))]
mod native;
mod panel;
mod path;
mod plan_job;
mod render;
mod settings;
mod stage;
mod state;
mod told;
#[cfg(target_arch = "wasm32")]
mod web;
mod zoom;

#[cfg(not(target_arch = "wasm32"))]
fn main() -> std::process::ExitCode {
    native::main()
}

#[cfg(target_arch = "wasm32")]
fn main() {
    web::main();
}
