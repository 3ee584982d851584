//! Changes since a baseline, as plain data.

use super::times::Suspect;

/// Relative growth up to this counts as none: sums over pixels may be added up in another order.
pub const ROUNDING: f64 = 1e-9;

/// The changes since the baseline, one line each.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Changes {
    /// The number of rows that both have and that could be compared. A check that compared nothing
    /// has checked nothing.
    pub compared: usize,
    /// The number of these whose times could be compared.
    pub timed: usize,
    /// What got slower, dearer, larger or less accurate: a failure.
    pub worse: Vec<String>,
    /// What got quicker, cheaper, smaller or more accurate.
    pub better: Vec<String>,
    /// Rows that the baseline lacks.
    pub new: Vec<String>,
    /// What only the baseline has, and what can't be compared with it: a failure, too.
    pub lost: Vec<String>,
    /// The names that would except all that is lost.
    pub except: Vec<String>,
    /// What was excepted, and what the reader must know.
    pub notes: Vec<String>,
    /// What looks slower; it is to be [timed again](super::time_again) before it counts as slower.
    pub suspects: Vec<Suspect>,
}
