//! The window of biases at which a technique has neither acne nor a gap, as plain data.

use serde::{Deserialize, Serialize};

/// Greatest tested normal offset, texels: more than the reach of the widest kernel.
pub(super) const GREATEST: f64 = 20.0;

/// Bias that the offset is added to.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Base {
    /// The technique's default bias.
    Own,
    /// No other bias. Faces that the default culls stay culled.
    Bare,
}

/// Amounts of bias at which a technique with default settings passes acne and gap.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct BiasWindow {
    /// The technique's name.
    pub technique: String,
    /// Settings without the offset.
    pub settings: String,
    /// Bias that the offset is added to.
    pub base: Base,
    /// Least and greatest passing normal offset, texels; `None` if no amount passes.
    pub passes: Option<[f64; 2]>,
    /// Whether it passes without any offset, which may be outside the widest window.
    pub passes_without: bool,
    /// Number of pixels on which backends differ, among those that rounding doesn't decide; `None`
    /// with a single backend.
    pub disagreeing: Option<u64>,
}

impl BiasWindow {
    /// Returns the window's width, texels; 0 if no amount passes.
    pub fn width(&self) -> f64 {
        self.passes.map_or(0.0, |[from, to]| to - from)
    }

    /// Reports whether the technique passes without an offset.
    pub fn needs_no_tuning(&self) -> bool {
        self.passes_without
    }

    /// Returns the window in a few words: `0 to 1.9 texels`.
    pub fn words(&self) -> String {
        match self.passes {
            None => "no amount passes".to_owned(),
            Some([from, to]) if to >= GREATEST => format!("{} texels and more", short(from)),
            Some([from, to]) => format!("{} to {} texels", short(from), short(to)),
        }
    }

    /// Returns a message if backends disagree.
    pub fn fault(&self) -> Option<String> {
        let n = self.disagreeing.filter(|n| *n > 0)?;
        Some(format!(
            "bias window of {} ({}): backends differ on {n} decided pixels",
            self.technique, self.settings
        ))
    }
}

/// Formats an amount with two significant digits.
fn short(amount: f64) -> String {
    match amount {
        0.0 => "0".to_owned(),
        a if a < 1.0 => format!("{a:.2}"),
        a if a < 10.0 => format!("{a:.1}"),
        a => format!("{a:.0}"),
    }
}
