//! A window that displays shadows: drag lights, compare techniques side by side, and measure them
//! against rays.

mod app;
mod bookmarks;
mod camera;
mod device;
mod drops;
mod focus;
mod gizmo;
mod job;
mod keys;
mod lights;
mod loading;
mod measure;
#[cfg(not(target_arch = "wasm32"))]
mod native;
mod opening;
mod pace;
mod panel;
mod path;
mod picker;
mod plan;
mod render;
mod report;
mod settings;
mod side;
mod stage;
mod steering;
mod view;
mod viewer;
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
