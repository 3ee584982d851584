//! What is measured of each technique: a row a technique.
//!
//! A technique implements [`CataloguedTechnique`] in a file of its own, which says what is
//! compared, planned and tested. [`CatalogueEntry::of`] makes a row of it, and a [`Catalogue`] is a
//! list of rows: of the built-in techniques, and of a program's own.

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

/// A technique that is measured, planned and tested.
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
/// let catalogue = Catalogue::built_in().with(CatalogueEntry::of::<Mine>())?;
/// assert_eq!(catalogue.names().last(), Some(&"mine"));
/// # Ok::<(), umbrage_core::Invalid>(())
/// ```
pub trait CataloguedTechnique: ListedTechnique {
    /// The settings worth comparing, for maps with these sides (texels) and this fit. Techniques
    /// without a map ignore both.
    ///
    /// By default the default settings, on maps of all sizes.
    fn compared(map_sizes: &[u32], fit: Fit) -> Vec<Self> {
        let default = Self::default();
        let Some(bias) = default.map().map(|map| map.bias) else {
            return vec![default];
        };
        sweeps::sweep(map_sizes, fit, &[bias], |map| default.clone().with_map(map))
    }

    /// The few settings that stand for it where frames of real size are compared: those that a
    /// program would begin with.
    ///
    /// By default the default settings, on the middle map.
    fn headline(map_sizes: &[u32], fit: Fit) -> Vec<Self> {
        let default = Self::default();
        let Some(bias) = default.map().map(|map| map.bias) else {
            return vec![default];
        };
        sweeps::middle(map_sizes, fit, &[bias], |map| default.clone().with_map(map))
    }

    /// The most triangles of a scene with which `compare` runs it, where all scenes are compared:
    /// larger ones take minutes. It runs if such a scene is named, or all settings are compared.
    /// `None` for no bound.
    const MAX_COMPARED_TRIANGLES: Option<usize> = None;

    /// Every setting that differs in code path, on maps of one small side (texels), for tests.
    ///
    /// By default the default settings, with every bias.
    fn exhaustive(map_size: u32) -> Vec<Self> {
        let default = Self::default();
        if default.map().is_none() {
            return vec![default];
        }
        sweeps::every_bias(map_size, |map| default.clone().with_map(map))
    }

    /// The settings that a planner tries under `light`. It puts those with a map on maps of all
    /// sides, and searches their bias; `map` says all else of the map.
    ///
    /// By default the default settings.
    fn candidates(map: ShadowMap, light: &Light) -> Vec<Candidate<Self>> {
        let _ = light;
        vec![Candidate::of(Self::default().with_map(map))]
    }

    /// Which biases a planner may give to its maps.
    const PLANNED_BIASES: PlannedBiases = PlannedBiases::All;

    /// Why a planner chose these settings, in a few words for people, where there is more to say
    /// than what was measured. `error` is the estimated RMSE, and `recipe` what is executed. Only
    /// called for techniques without a map.
    fn why_chosen(&self, error: f64, recipe: &Recipe) -> Option<String> {
        let _ = (error, recipe);
        None
    }

    /// What the closed forms of ideal lights demand of it at single points, with `map`; `None` if
    /// it can't be queried for single points, or doesn't meet them.
    ///
    /// By default the default settings are right where no edge is within
    /// [`kernel_reach`](Self::kernel_reach); techniques without a map have no demand.
    fn closed_form(map: ShadowMap) -> Option<ClosedFormDemand<Self>> {
        let technique = Self::default().with_map(map);
        technique.map()?;
        let reach = technique.kernel_reach()?;
        Some(ClosedFormDemand::new(technique, reach))
    }

    /// Returns how far, in texels, lookups go beyond the point of a map on which a receiver falls,
    /// along each axis: 0 for one texel, 1 for the 3 x 3 around it. If it differs from one receiver
    /// to the next, this is the narrowest, and [`CataloguedKernel::reach`] returns each. `None` if
    /// no map of what the light sees is looked up, or it isn't known: reports then say nothing of
    /// its maps.
    fn kernel_reach(&self) -> Option<f32> {
        None
    }

    /// Returns what is measured of a kernel, if recipes of this technique receive with it.
    fn kernel(kernel: &dyn ReceiveKernel) -> Option<&dyn CataloguedKernel> {
        let _ = kernel;
        None
    }

    /// Returns how many texels a filter loads for each that it makes, if recipes of this technique
    /// have it and it loads more than one. One is part of the price of any filter.
    fn filter_loads(filter: &dyn FilterKernel) -> Option<u32> {
        let _ = filter;
        None
    }

    /// How often random scenes are rendered with it, relative to a technique with 1.
    const RANDOM_WEIGHT: u32 = 1;

    /// The ranges that [`random`](Self::random)'s numbers are drawn from, for tests.
    fn random_parameters() -> Vec<RandomParameter> {
        Vec::new()
    }

    /// Random settings: with a random map, and a number drawn for each of
    /// [`random_parameters`](Self::random_parameters), in their order.
    fn random(map: ShadowMap, numbers: &[f32]) -> Self {
        let _ = numbers;
        Self::default().with_map(map)
    }

    /// Whether quick comparisons of all techniques run it. They leave out what takes long and
    /// seldom wins. A technique that is named always runs.
    const IS_PREVIEWED: bool = true;
}

/// What a planner tries of one technique and kernel.
#[derive(Clone, Debug, PartialEq)]
pub enum Candidate<T> {
    /// One setting. On maps of all sides, if it has a map.
    One(T),
    /// Settings from cheap to dear, each of which errs less than the one before.
    Series {
        /// Rising in cost.
        settings: Vec<T>,
        /// The factor by which one step divides the error at most.
        max_gain: f64,
    },
}

impl<T> Candidate<T> {
    /// One setting.
    pub fn of(setting: T) -> Self {
        Self::One(setting)
    }

    /// The same with every setting converted.
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

/// Which biases a planner may choose from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PlannedBiases {
    /// All kinds.
    All,
    /// All that don't need a polygon offset: for maps that are peeled.
    WithoutPolygonOffset,
    /// The technique's own alone.
    Own,
}

/// What closed forms demand of a technique: at points farther from all edges than its kernel
/// reaches, its answer must be the formula's.
#[derive(Clone, Debug, PartialEq)]
pub struct ClosedFormDemand<T> {
    /// The technique, with its settings.
    pub technique: T,
    /// How far its kernel reaches beyond the receiver's own texel, texels.
    pub reach: f32,
    /// How far its answer may be from the formula's: 0 for comparisons, which know light and dark
    /// alone.
    pub tolerance: f32,
    /// Whether it serves closed bodies alone, and neither sheets nor rooms without an outside.
    pub closed_bodies: bool,
}

impl<T> ClosedFormDemand<T> {
    /// Demands that `technique`, whose kernel reaches `reach` texels, is right in all scenes.
    pub fn new(technique: T, reach: f32) -> Self {
        Self {
            technique,
            reach,
            tolerance: 0.0,
            closed_bodies: false,
        }
    }
}

/// A number of a technique's settings, as tests draw it.
#[derive(Clone, Debug, PartialEq)]
pub enum RandomParameter {
    /// A whole number.
    Count(Range<u32>),
    /// A length.
    Length(Range<f32>),
    /// The place of a [`Pattern`](umbrage_techniques::Pattern) in
    /// [`Pattern::ALL`](umbrage_techniques::Pattern::ALL).
    Pattern,
    /// 0 or 1.
    Switch,
}

#[cfg(test)]
mod tests;
