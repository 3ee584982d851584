//! Changes since a baseline, as plain data.

use super::times::Suspect;

/// Maximum relative growth that counts as none: sums over pixels may have another order.
pub const ROUNDING: f64 = 1e-9;

/// Changes since the baseline, one line each.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Changes {
    /// Number of compared rows. A check that compares nothing is no check.
    pub compared: usize,
    /// Number of rows whose times were compared.
    pub timed: usize,
    /// Figures that increased in time, cost, memory or error: a failure.
    pub worse: Vec<String>,
    /// Figures that decreased in time, cost, memory or error.
    pub better: Vec<String>,
    /// Rows that the baseline doesn't have.
    pub new: Vec<String>,
    /// Parts of the baseline that are missing or can't be compared: a failure, too.
    pub lost: Vec<String>,
    /// Names of exceptions that would cover all of `lost`.
    pub except: Vec<String>,
    /// Applied exceptions, and notices for the reader.
    pub notes: Vec<String>,
    /// Rows and techniques that look slower. They must be [timed again](super::time_again) before
    /// they count.
    pub suspects: Vec<Suspect>,
}
