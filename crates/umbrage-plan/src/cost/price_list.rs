//! Prices of all kinds of backend as a file, so that plans and comparisons count with those of the user's machine.

use super::{CostModel, KINDS};
use serde::{Deserialize, Serialize};
use umbrage_core::Invalid;

/// The prices of each kind of backend.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PriceList {
    /// What they were measured on, in words.
    #[serde(default)]
    pub measured_on: String,
    /// The CPU backend's.
    pub cpu: CostModel,
    /// The wgpu backend's.
    pub wgpu: CostModel,
}

/// The built-in prices: see [`CostModel::CPU`] and [`CostModel::SOFTWARE_GPU`].
impl Default for PriceList {
    fn default() -> Self {
        Self {
            measured_on: String::new(),
            cpu: CostModel::CPU,
            wgpu: CostModel::SOFTWARE_GPU,
        }
    }
}

impl PriceList {
    /// Returns the prices for a kind of backend: `cpu`'s, or wgpu's for all others.
    pub fn of(&self, kind: &str) -> CostModel {
        if kind == "cpu" { self.cpu } else { self.wgpu }
    }

    /// Reads prices from TOML.
    ///
    /// # Errors
    /// Errors if the text isn't TOML, a price is missing or unknown, or one is negative or not finite.
    pub fn from_toml(text: &str) -> Result<Self, Invalid> {
        let list: Self = toml::from_str(text).map_err(|e| {
            let help = "write it anew with `bench --costs --write FILE`";
            Invalid::new("price list", format!("cannot be read: {e}"), help)
        })?;
        for (kind, model) in [("cpu", &list.cpu), ("wgpu", &list.wgpu)] {
            for (name, price) in KEYS.iter().zip(model.nanoseconds) {
                if !(price >= 0.0 && price.is_finite()) {
                    let why = format!("`{kind}.{name}` is {price}");
                    return Err(Invalid::new(
                        "price list",
                        why,
                        "give nanoseconds, 0 or more",
                    ));
                }
            }
        }
        Ok(list)
    }

    /// Returns the prices as TOML.
    ///
    /// # Errors
    /// Errors if they can't be written so, which does not happen with finite prices.
    pub fn to_toml(&self) -> Result<String, Invalid> {
        let body = toml::to_string(self)
            .map_err(|e| Invalid::new("price list", e.to_string(), "give finite prices"))?;
        Ok(format!("{COMMENT}{body}"))
    }
}

/// What a file begins with.
const COMMENT: &str =
    "# Nanoseconds that one piece of each kind of work takes. Written by `bench --costs --write`;
# read by `--prices` of `compare` and `plan`.
";

/// The prices' names in files, in the order of [`KIND_NAMES`](super::KIND_NAMES).
const KEYS: [&str; KINDS] = [
    "pass",
    "triangle",
    "covered_texel",
    "cleared_texel",
    "filtered_texel",
    "receiver",
    "tap",
    "comparison_sample",
    "ray_level",
];

/// [`CostModel`] in files: each price by its name.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct NamedPrices {
    pass: f64,
    triangle: f64,
    covered_texel: f64,
    cleared_texel: f64,
    filtered_texel: f64,
    receiver: f64,
    tap: f64,
    comparison_sample: f64,
    ray_level: f64,
}

impl From<NamedPrices> for CostModel {
    fn from(prices: NamedPrices) -> Self {
        Self {
            nanoseconds: [
                prices.pass,
                prices.triangle,
                prices.covered_texel,
                prices.cleared_texel,
                prices.filtered_texel,
                prices.receiver,
                prices.tap,
                prices.comparison_sample,
                prices.ray_level,
            ],
        }
    }
}

impl From<CostModel> for NamedPrices {
    fn from(model: CostModel) -> Self {
        let [
            pass,
            triangle,
            covered_texel,
            cleared_texel,
            filtered_texel,
            receiver,
            tap,
            comparison_sample,
            ray_level,
        ] = model.nanoseconds;
        Self {
            pass,
            triangle,
            covered_texel,
            cleared_texel,
            filtered_texel,
            receiver,
            tap,
            comparison_sample,
            ray_level,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn prices_survive_a_file() {
        let mut list = PriceList {
            measured_on: "a machine".to_owned(),
            ..PriceList::default()
        };
        list.cpu.nanoseconds[3] = 7.25;
        let text = list.to_toml().expect("finite");
        assert_eq!(PriceList::from_toml(&text).expect("whole"), list);
        for key in KEYS {
            assert_eq!(text.matches(&format!("\n{key} = ")).count(), 2, "{key}");
        }
        assert_eq!(list.of("cpu"), list.cpu);
        assert_eq!(list.of("wgpu"), list.wgpu);
    }

    #[test]
    fn wrong_prices_are_refused_by_name() {
        let text = PriceList::default().to_toml().expect("finite");
        for (from, to, word) in [
            ("tap = ", "tape = ", "tape"),
            ("ray_level = 7.29", "ray_level = -7.29", "cpu.ray_level"),
            ("ray_level = 7.29", "ray_level = nan", "cpu.ray_level"),
            ("ray_level = 7.29\n", "", "ray_level"),
        ] {
            let spoilt = text.replacen(from, to, 1);
            assert_ne!(spoilt, text, "{from}");
            let error = PriceList::from_toml(&spoilt)
                .expect_err("spoilt")
                .to_string();
            assert!(error.contains(word), "{error}");
        }
    }
}
