//! What the examples beside this file share with the tests: techniques written as a user of the library would.

pub mod variance;
