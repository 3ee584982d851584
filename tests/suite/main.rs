//! Tests across packages.

mod absurd;
mod add_shadows;
mod assembled;
mod functions;
mod goldens;
mod layouts;
mod light_matrices;
mod messages;
mod technique_table;
