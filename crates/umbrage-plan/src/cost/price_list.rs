//! Price file for all kinds of backend, so that plans and comparisons use the prices of the user's
//! machine.

use super::{CostModel, KINDS};
use serde::{Deserialize, Deserializer, Serialize, de::Error};
use std::collections::BTreeMap;
use umbrage_core::Invalid;

/// Prices of each kind of backend.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PriceList {
    /// Description of the machine that was measured.
    #[serde(default)]
    pub measured_on: String,
    /// Prices of the CPU backend.
    #[serde(deserialize_with = "cpu_prices")]
    pub cpu: CostModel,
    /// Prices of the wgpu backend.
    pub wgpu: CostModel,
}

/// Uses the built-in prices: see [`CostModel::CPU`] and [`CostModel::SOFTWARE_GPU`].
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
    /// Returns the prices for a kind of backend: those of `cpu`, or of wgpu for all others.
    pub fn model_for_backend(&self, kind: &str) -> CostModel {
        if kind == "cpu" { self.cpu } else { self.wgpu }
    }

    /// Reads prices from TOML.
    ///
    /// # Errors
    /// Errors if the text is not TOML, a price is missing or unknown, or one is negative or not
    /// finite.
    pub fn from_toml(text: &str) -> Result<Self, Invalid> {
        let list: Self = toml::from_str(text).map_err(|e| {
            let help = "write it again with `bench --costs --write FILE`";
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
    /// Errors if the prices can't be serialized, which does not happen with finite prices.
    pub fn to_toml(&self) -> Result<String, Invalid> {
        let body = toml::to_string(self)
            .map_err(|e| Invalid::new("price list", e.to_string(), "give finite prices"))?;
        Ok(format!("{COMMENT}{body}"))
    }
}

/// Header of a price file.
const COMMENT: &str =
    "# Nanoseconds per unit of each kind of work. Written by `bench --costs --write`;
# read by `--prices` of `compare` and `plan`.
";

/// Names of the prices in files, in the order of [`KIND_NAMES`](super::KIND_NAMES).
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
    "volume_face",
    "counted_texel",
    "filter_load",
    "cut_out_texel",
    "hierarchy_caster",
    "hierarchy_level",
];

/// Names of the prices that older files lack: those of a device's hierarchy.
const HIERARCHY_KEYS: [&str; 2] = ["hierarchy_caster", "hierarchy_level"];

/// Reads the prices of the CPU, with the built-in ones of hierarchies if the file is older.
fn cpu_prices<'de, D: Deserializer<'de>>(deserializer: D) -> Result<CostModel, D::Error> {
    let mut prices = NamedPrices::deserialize(deserializer)?;
    let known = NamedPrices::from(CostModel::CPU);
    for key in HIERARCHY_KEYS {
        prices.entry(key.to_owned()).or_insert(known[key]);
    }
    CostModel::try_from(prices).map_err(Error::custom)
}

/// Adds the prices of hierarchies to those of an older file: the software driver's, scaled by the
/// price of rays, which also walk a hierarchy.
fn add_hierarchy_prices(prices: &mut NamedPrices) {
    const RAY: &str = "ray_level";
    let known = NamedPrices::from(CostModel::SOFTWARE_GPU);
    let Some(ray) = prices.get(RAY) else {
        return;
    };
    let scale = ray / known[RAY];
    for key in HIERARCHY_KEYS {
        prices.entry(key.to_owned()).or_insert(scale * known[key]);
    }
}

/// Form of [`CostModel`] in files: each price by name.
pub(super) type NamedPrices = BTreeMap<String, f64>;

impl TryFrom<NamedPrices> for CostModel {
    type Error = String;

    fn try_from(mut prices: NamedPrices) -> Result<Self, String> {
        add_hierarchy_prices(&mut prices);
        let mut nanoseconds = [0.0; KINDS];
        for (name, price) in KEYS.iter().zip(&mut nanoseconds) {
            let named = prices.remove(*name);
            *price = named.ok_or_else(|| format!("the price `{name}` is missing"))?;
        }
        match prices.keys().next() {
            Some(unknown) => Err(format!("there is no price `{unknown}`")),
            None => Ok(Self { nanoseconds }),
        }
    }
}

impl From<CostModel> for NamedPrices {
    fn from(model: CostModel) -> Self {
        let names = KEYS.iter().map(|name| (*name).to_owned());
        names.zip(model.nanoseconds).collect()
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
        assert_eq!(list.model_for_backend("cpu"), list.cpu);
        assert_eq!(list.model_for_backend("wgpu"), list.wgpu);
    }

    #[test]
    fn older_files_get_prices_of_hierarchies() {
        let mut list = PriceList::default();
        list.cpu.nanoseconds = list.cpu.nanoseconds.map(|price| 2.0 * price);
        list.wgpu.nanoseconds = list.wgpu.nanoseconds.map(|price| 2.0 * price);
        let text = list.to_toml().expect("finite");
        let lines = text.lines();
        let older: Vec<&str> = lines
            .filter(|line| !line.starts_with("hierarchy"))
            .collect();
        let read = PriceList::from_toml(&older.join("\n")).expect("complete");
        for (read, written) in read.wgpu.nanoseconds.iter().zip(list.wgpu.nanoseconds) {
            assert!((read - written).abs() <= 1e-9 * written);
        }
        // Those of the CPU are not measured.
        let [read, known] = [read.cpu, CostModel::CPU].map(NamedPrices::from);
        for key in HIERARCHY_KEYS {
            assert_eq!(read[key], known[key], "{key}");
        }
    }

    #[test]
    fn wrong_prices_are_refused_by_name() {
        let text = PriceList::default().to_toml().expect("finite");
        for (from, to, word) in [
            ("\ntap = ", "\ntape = ", "`tap` is missing"),
            ("\ntap = ", "\ntape = 1.0\ntap = ", "no price `tape`"),
            ("\ntap = ", "\ntap = -", "cpu.tap"),
            ("\ntap = ", "\ntap = nan # ", "cpu.tap"),
            ("\ntap = ", "\n# ", "`tap` is missing"),
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
