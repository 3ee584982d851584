//! Helpers shared by the tests.

pub mod absurd_values;
pub mod adapter;
pub mod agreed;
pub mod assembled;
pub mod driver_model;
pub mod foreign;
pub mod fusible;
pub mod golden;
pub mod gpu;
pub mod layouts;
pub mod light_program;
pub mod light_stage;
pub mod painted;
pub mod random_scene;
pub mod stage;
pub mod technique_table;
pub mod twins;
