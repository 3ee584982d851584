//! The first of four tests of twins: both halves of each twin function, on the same 65,536 inputs.

mod inputs;
mod mutants;
mod run;
mod ulps;
mod wrapper;

pub use inputs::{COUNT, draw};
pub use mutants::{Mutant, mutants};
pub use ulps::{Difference, difference};
pub use wrapper::{shader, wgsl_types};

use crate::{adapter::TestDevice, driver_model::DriverModel};
use umbrage_core::Twin;

/// Reason why a pair is not a pair of twins.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum Fault {
    /// The WGSL doesn't compile.
    #[error("`{twin}` does not compile: {message}")]
    Wgsl {
        /// The pair.
        twin: &'static str,
        /// The compiler's message.
        message: String,
    },
    /// The WGSL half is missing, or its parameters or result have other types than the Rust half's.
    #[error("`{twin}` in Rust is {rust}; in WGSL it is {wgsl}")]
    Signature {
        /// The pair.
        twin: &'static str,
        /// Types such as `(vec3f, f32) -> f32`.
        rust: String,
        /// Types of the WGSL half, or `missing`.
        wgsl: String,
    },
    /// The halves disagree.
    #[error(
        "`{twin}` differs on {count} of {COUNT} inputs, allowed {allowed} ulps; worst: {worst}"
    )]
    Differs {
        /// The pair.
        twin: &'static str,
        /// Number of different results.
        count: usize,
        /// The pair's tolerance.
        allowed: u32,
        /// The worst case.
        worst: Box<Difference>,
    },
    /// Nearly all results are equal, or NaN: the inputs prove nothing.
    #[error(
        "`{twin}`: {useful} of {COUNT} results differ from the commonest and are numbers, too few to prove anything"
    )]
    Dull {
        /// The pair.
        twin: &'static str,
        /// Number of meaningful results.
        useful: usize,
    },
}

/// Runs both halves of a pair on `inputs`, and returns the greatest difference in ulps.
///
/// # Errors
/// Returns an error if they aren't twins.
pub fn check(on: &TestDevice, twin: &Twin, inputs: &[u32]) -> Result<u64, Fault> {
    check_under(on, twin, inputs, None)
}

/// Runs [`check`] with the WGSL half on a driver that rounds differently.
///
/// # Errors
/// Returns an error if they aren't twins there.
pub fn check_under(
    on: &TestDevice,
    twin: &Twin,
    inputs: &[u32],
    model: Option<DriverModel>,
) -> Result<u64, Fault> {
    let mut text = shader(twin)?;
    if let Some(model) = model {
        text = model.rewrite(&text);
    }
    let words: usize = twin.parameters.iter().map(|t| wrapper::count(t)).sum();
    let expected: Vec<u32> = inputs.chunks_exact(words).flat_map(twin.call).collect();
    ulps::useful(twin, &expected)?;
    let got =
        run::run(on, &text, inputs, expected.len(), inputs.len() / words).map_err(|message| {
            Fault::Wgsl {
                twin: twin.name,
                message,
            }
        })?;
    ulps::compare(twin, inputs, &expected, &got)
}
