//! What the examples beside this file share with the tests: techniques written as a user of the library would, and the faults that
//! the documentation shows.

pub mod contact;
pub mod failures;
pub mod light_set;
pub mod panes;
pub mod variance;
