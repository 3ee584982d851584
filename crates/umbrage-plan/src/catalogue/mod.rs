//! Catalogue of measured techniques, with one entry per technique.
//!
//! A technique implements [`CataloguedTechnique`] in its own file, which defines how it is
//! compared, planned and tested. [`CatalogueEntry::for_technique`] creates its entry. A
//! [`Catalogue`] is a list of entries of built-in techniques and of a program's own.

mod entry;
mod evsm;
mod exact;
mod hard;
pub mod kernel;
mod midpoint;
mod moments;
mod msm;
mod pcf;
mod pcf_disc;
mod pcf_dithered;
mod pcf_hardware;
mod pcf_merged;
mod pcss;
mod planar;
mod second_depth;
mod soft;
pub mod sweeps;
mod traced;
mod unshadowed;
mod volumes;
mod vsm;

pub use entry::{Catalogue, CatalogueEntry, all, find};
pub use kernel::{CataloguedKernel, KernelCost};

use std::ops::Range;
use umbrage_core::{FilterKernel, Fit, Light, ReceiveKernel, Recipe};
use umbrage_techniques::{ListedTechnique, ShadowMap};

/// Technique that is measured, planned and tested.
///
/// Each item has a default: the default settings are compared and planned.
///
/// ```
/// use umbrage_plan::catalogue::{Catalogue, CatalogueEntry, CataloguedTechnique};
/// use umbrage_techniques::{Hard, ListedTechnique, MapFilter as _, ShadowMap};
/// # use serde::{Deserialize, Serialize};
/// # use umbrage_core::{RecipeError, Recipe, ShadowTechnique, View};
/// # #[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
/// # #[serde(default, deny_unknown_fields)]
/// # struct Mine { map: ShadowMap }
/// # impl ShadowTechnique for Mine {
/// #     fn name(&self) -> &'static str { "mine" }
/// #     fn recipe(&self, view: &View<'_>) -> Result<Recipe, RecipeError> {
/// #         Hard {}.on(self.map).recipe(view)
/// #     }
/// # }
/// # impl ListedTechnique for Mine {
/// #     const SUMMARY: &'static str = "one comparison, mine";
/// #     fn map(&self) -> Option<&ShadowMap> { Some(&self.map) }
/// #     fn with_map(self, map: ShadowMap) -> Self { Self { map } }
/// # }
/// // `Mine` implements `ListedTechnique`.
/// impl CataloguedTechnique for Mine {}
///
/// let catalogue = Catalogue::built_in().with(CatalogueEntry::for_technique::<Mine>())?;
/// assert_eq!(catalogue.names().last(), Some(&"mine"));
/// # Ok::<(), umbrage_core::Invalid>(())
/// ```
pub trait CataloguedTechnique: ListedTechnique {
    /// Returns the settings to compare, for maps with these sides (texels) and this fit.
    ///
    /// Techniques without a map ignore both. Defaults to the default settings, on maps of all
    /// sizes.
    fn compared_settings(map_sizes: &[u32], fit: Fit) -> Vec<Self> {
        let default = Self::default();
        let Some(bias) = default.map().map(|map| map.bias) else {
            return vec![default];
        };
        sweeps::sweep(map_sizes, fit, &[bias], |map| default.clone().with_map(map))
    }

    /// Returns few representative settings for comparisons of full-size scenes: a program would
    /// start with these.
    ///
    /// Defaults to the default settings, on the middle map.
    fn headline(map_sizes: &[u32], fit: Fit) -> Vec<Self> {
        let default = Self::default();
        let Some(bias) = default.map().map(|map| map.bias) else {
            return vec![default];
        };
        sweeps::middle(map_sizes, fit, &[bias], |map| default.clone().with_map(map))
    }

    /// Greatest number of triangles of a scene with which `compare` runs it when it compares all
    /// scenes, since larger ones take minutes. A scene that is named, or a comparison of all
    /// settings, ignores the bound. `None` means unbounded.
    const MAX_COMPARED_TRIANGLES: Option<usize> = None;

    /// Returns every setting with a different code path, on maps of one small side (texels), for
    /// tests.
    ///
    /// Defaults to the default settings, with every bias.
    fn exhaustive(map_size: u32) -> Vec<Self> {
        let default = Self::default();
        if default.map().is_none() {
            return vec![default];
        }
        sweeps::every_bias(map_size, |map| default.clone().with_map(map))
    }

    /// Returns the settings that a planner evaluates under `light`.
    ///
    /// It evaluates those with a map on maps of all sides, and searches their bias. `map` has the
    /// map's other parameters. Defaults to the default settings.
    fn candidates(map: ShadowMap, light: &Light) -> Vec<Candidate<Self>> {
        let _ = light;
        vec![Candidate::from_setting(Self::default().with_map(map))]
    }

    /// Biases that a planner may assign to its maps.
    const PLANNED_BIASES: PlannedBiases = PlannedBiases::All;

    /// Returns a short reason why a planner chose these settings, beyond the measurements. `error`
    /// is the estimated RMSE, and `recipe` is the executed recipe. Only called for techniques
    /// without a map.
    fn why_chosen(&self, error: f64, recipe: &Recipe) -> Option<String> {
        let _ = (error, recipe);
        None
    }

    /// Returns the requirements that the closed forms of ideal lights impose at single points, with
    /// `map`. Returns `None` if it can't be evaluated at single points, or doesn't meet them.
    ///
    /// Defaults to the default settings, exact where no edge is within
    /// [`kernel_reach`](Self::kernel_reach). Techniques without a map have no requirements by
    /// default.
    fn closed_form(map: ShadowMap) -> Option<ClosedFormDemand<Self>> {
        let technique = Self::default().with_map(map);
        technique.map()?;
        let reach = technique.kernel_reach()?;
        Some(ClosedFormDemand::new(technique, reach))
    }

    /// Returns the reach, in texels, of lookups beyond a receiver's point on the map, along each
    /// axis: 0 for one texel, 1 for the 3 x 3 around it.
    ///
    /// If it differs between receivers, this is the least, and [`CataloguedKernel::reach`] returns
    /// each. Returns `None` if no map is looked up, or the reach is unknown. Reports then omit its
    /// maps.
    fn kernel_reach(&self) -> Option<f32> {
        None
    }

    /// Returns the measured properties of a kernel, if recipes of this technique receive with it.
    fn kernel(kernel: &dyn ReceiveKernel) -> Option<&dyn CataloguedKernel> {
        let _ = kernel;
        None
    }

    /// Returns the number of texels that a filter loads for each that it writes, if recipes of this
    /// technique use it and it loads more than one. The first is part of the price of any filter.
    fn filter_loads(filter: &dyn FilterKernel) -> Option<u32> {
        let _ = filter;
        None
    }

    /// Frequency of random scenes with it, relative to a technique with 1.
    const RANDOM_WEIGHT: u32 = 1;

    /// Returns the ranges of the numbers for [`random`](Self::random), for tests.
    fn random_parameters() -> Vec<RandomParameter> {
        Vec::new()
    }

    /// Returns random settings from a random map, and one number for each of
    /// [`random_parameters`](Self::random_parameters), in order.
    fn random(map: ShadowMap, numbers: &[f32]) -> Self {
        let _ = numbers;
        Self::default().with_map(map)
    }

    /// True if quick comparisons of all techniques run it. They skip expensive techniques that
    /// seldom win. A technique that is named always runs.
    const IS_PREVIEWED: bool = true;
}

/// Candidates of a planner for one technique and kernel.
#[derive(Clone, Debug, PartialEq)]
pub enum Candidate<T> {
    /// One setting, evaluated on maps of all sides if it has a map.
    One(T),
    /// Settings from cheap to expensive, each with a smaller error than the one before.
    Series {
        /// Settings, by rising cost.
        settings: Vec<T>,
        /// Greatest factor by which one step divides the error.
        max_gain: f64,
    },
}

impl<T> Candidate<T> {
    /// Returns a candidate of one setting.
    pub fn from_setting(setting: T) -> Self {
        Self::One(setting)
    }

    /// Returns the candidate with every setting converted.
    pub fn map<U>(self, convert: impl Fn(T) -> U) -> Candidate<U> {
        match self {
            Self::One(setting) => Candidate::One(convert(setting)),
            Self::Series { settings, max_gain } => Candidate::Series {
                settings: settings.into_iter().map(convert).collect(),
                max_gain,
            },
        }
    }
}

/// Biases that a planner may choose from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PlannedBiases {
    /// All kinds.
    All,
    /// All kinds without a polygon offset, for peeled maps.
    WithoutPolygonOffset,
    /// Only the technique's own bias.
    Own,
}

/// Requirements that closed forms impose on a technique. At points farther from all edges than its
/// kernel reaches, its visibility must equal the formula's.
#[derive(Clone, Debug, PartialEq)]
pub struct ClosedFormDemand<T> {
    /// The technique, with its settings.
    pub technique: T,
    /// Reach of its kernel beyond the receiver's own texel, texels.
    pub reach: f32,
    /// Greatest difference from the formula: 0 for comparisons, which return only light or dark.
    pub tolerance: f32,
    /// True if it supports only closed bodies, and neither sheets nor rooms without an outside.
    pub closed_bodies: bool,
}

impl<T> ClosedFormDemand<T> {
    /// Requires that `technique`, whose kernel reaches `reach` texels, is exact in all scenes.
    pub fn new(technique: T, reach: f32) -> Self {
        Self {
            technique,
            reach,
            tolerance: 0.0,
            closed_bodies: false,
        }
    }
}

/// Parameter of a technique's settings that tests draw at random.
#[derive(Clone, Debug, PartialEq)]
pub enum RandomParameter {
    /// A whole number.
    Count(Range<u32>),
    /// A length.
    Length(Range<f32>),
    /// Index of a [`Pattern`](umbrage_techniques::Pattern) in
    /// [`Pattern::ALL`](umbrage_techniques::Pattern::ALL).
    Pattern,
    /// 0 or 1.
    Switch,
}

#[cfg(test)]
mod tests;
