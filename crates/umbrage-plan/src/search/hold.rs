//! Share of several cameras for which a plan holds.

use serde::{Deserialize, Serialize};
use umbrage_core::Invalid;

/// Cameras for which a plan's bounds hold.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Hold {
    /// All cameras: the worst one decides.
    #[default]
    Worst,
    /// At least this share of the cameras, above 0 up to 1; the others may be worse. With fewer
    /// than 20 cameras, a share of .95 means all.
    Share(f64),
}

impl Hold {
    /// Checks the share.
    ///
    /// # Errors
    /// Errors if the share is not above 0 and at most 1.
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

    /// Returns the least figure that the required number of cameras does not exceed, or 0 without
    /// cameras.
    pub(super) fn required_figure(self, mut figures: Vec<f64>) -> f64 {
        figures.sort_by(f64::total_cmp);
        let count = figures.len();
        let needed = match self {
            Self::Worst => count,
            // Subtract a little, so that a share equal to a whole number of cameras is not rounded
            // up.
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
        assert_eq!(Hold::Worst.required_figure(figures.clone()), 20.0);
        assert_eq!(Hold::Share(0.95).required_figure(figures.clone()), 19.0);
        assert_eq!(Hold::Share(0.951).required_figure(figures.clone()), 20.0);
        assert_eq!(
            Hold::Share(0.95).required_figure(figures[..19].to_vec()),
            19.0
        );
        assert_eq!(Hold::Share(0.01).required_figure(figures), 1.0);
        assert_eq!(Hold::Worst.required_figure(Vec::new()), 0.0);
    }

    #[test]
    fn shares_of_nothing_are_refused() {
        for share in [0.0, -1.0, 1.1, f64::NAN] {
            assert!(Hold::Share(share).validate().is_err(), "{share}");
        }
        assert!(Hold::Share(1.0).validate().is_ok() && Hold::Worst.validate().is_ok());
    }
}
