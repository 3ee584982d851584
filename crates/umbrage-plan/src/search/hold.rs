//! For how many of several cameras a plan holds.

use serde::{Deserialize, Serialize};
use umbrage_core::Invalid;

/// For how many of several cameras a plan's bounds hold.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Hold {
    /// For all: the worst one decides.
    #[default]
    Worst,
    /// For this share of them at least, above 0 up to 1; the others may be worse. Of fewer than 20
    /// cameras a share of .95 is all.
    Share(f64),
}

impl Hold {
    /// Checks the share.
    ///
    /// # Errors
    /// Errors if it is not above 0 and up to 1.
    pub fn validate(self) -> Result<(), Invalid> {
        match self {
            Self::Share(share) if !(share > 0.0 && share <= 1.0) => Err(Invalid::new(
                "share of the cameras",
                format!("is {share}"),
                "use more than 0, up to 1, such as 0.95",
            )),
            Self::Worst | Self::Share(_) => Ok(()),
        }
    }

    /// Returns the figure that enough of the cameras do not exceed: the least one of theirs for
    /// which that is so; 0 of none.
    pub(super) fn of(self, mut figures: Vec<f64>) -> f64 {
        figures.sort_by(f64::total_cmp);
        let count = figures.len();
        let needed = match self {
            Self::Worst => count,
            // A little less, so that a share that is a whole number of cameras is not rounded up to
            // the next.
            Self::Share(share) => (share * count as f64 - 1e-9).ceil() as usize,
        };
        figures
            .get(needed.clamp(1, count.max(1)) - 1)
            .copied()
            .unwrap_or_default()
    }
}

#[cfg(test)]
mod tests {
    use super::Hold;

    #[test]
    fn a_share_leaves_out_the_worst() {
        let figures: Vec<f64> = (1..=20).map(f64::from).collect();
        assert_eq!(Hold::Worst.of(figures.clone()), 20.0);
        assert_eq!(Hold::Share(0.95).of(figures.clone()), 19.0);
        assert_eq!(Hold::Share(0.951).of(figures.clone()), 20.0);
        assert_eq!(Hold::Share(0.95).of(figures[..19].to_vec()), 19.0);
        assert_eq!(Hold::Share(0.01).of(figures), 1.0);
        assert_eq!(Hold::Worst.of(Vec::new()), 0.0);
    }

    #[test]
    fn shares_of_nothing_are_refused() {
        for share in [0.0, -1.0, 1.1, f64::NAN] {
            assert!(Hold::Share(share).validate().is_err(), "{share}");
        }
        assert!(Hold::Share(1.0).validate().is_ok() && Hold::Worst.validate().is_ok());
    }
}
