//! Tests across packages.

mod absurd;
mod add_shadows;
mod assembled;
mod functions;
mod fusing;
mod fuzz_corpus;
mod goldens;
mod layouts;
mod light_matrices;
mod messages;
mod pages;
mod technique_table;
