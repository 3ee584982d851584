//! Entries of the catalogue of measured techniques, and the catalogue.

use super::{
    Candidate, CataloguedTechnique, ClosedFormDemand, PlannedBiases, RandomParameter,
    kernel::{CataloguedKernel, UnknownKernel},
};
use std::{
    fmt::{self, Debug, Formatter},
    sync::LazyLock,
};
use umbrage_core::{
    FilterKernel, Fit, Invalid, Light, ReceiveKernel, Recipe, ShadowTechnique as _,
};
use umbrage_techniques::{ShadowMap, TechniqueEntry, TechniquePreset, for_each_technique};

/// Entry of a catalogue: the items of a [`CataloguedTechnique`], without its type.
#[derive(Clone, Copy)]
pub struct CatalogueEntry {
    /// The technique's row in the library's list: name, summary, default settings.
    pub technique: TechniqueEntry,
    /// Settings to compare, for the given map sides (texels) and fit:
    /// [`CataloguedTechnique::compared_settings`].
    pub settings: fn(map_sizes: &[u32], fit: Fit) -> Vec<TechniquePreset>,
    /// Few representative settings, for the given map sides (texels) and fit:
    /// [`CataloguedTechnique::headline`].
    pub headline: fn(map_sizes: &[u32], fit: Fit) -> Vec<TechniquePreset>,
    /// Bound on the scene size: [`CataloguedTechnique::MAX_COMPARED_TRIANGLES`].
    pub max_compared_triangles: Option<usize>,
    /// Every setting with a different code path, at one map side (texels):
    /// [`CataloguedTechnique::exhaustive`].
    pub exhaustive: fn(map_size: u32) -> Vec<TechniquePreset>,
    /// Candidates of a planner: [`CataloguedTechnique::candidates`].
    pub candidates: fn(map: ShadowMap, light: &Light) -> Vec<Candidate<TechniquePreset>>,
    /// Biases that a planner may assign to its maps.
    pub planned_biases: PlannedBiases,
    /// Reason why a planner chose these settings: [`CataloguedTechnique::why_chosen`]. Returns
    /// `None` for presets of other techniques.
    pub why_chosen: fn(preset: &TechniquePreset, error: f64, recipe: &Recipe) -> Option<String>,
    /// Requirements of closed forms: [`CataloguedTechnique::closed_form`].
    pub closed_form: fn(map: ShadowMap) -> Option<ClosedFormDemand<TechniquePreset>>,
    /// Reach of its lookups: [`CataloguedTechnique::kernel_reach`]. Returns `None` for presets of
    /// other techniques.
    pub kernel_reach: fn(&TechniquePreset) -> Option<f32>,
    /// Measured properties of its kernel: [`CataloguedTechnique::kernel`].
    pub kernel: fn(&dyn ReceiveKernel) -> Option<&dyn CataloguedKernel>,
    /// Texels that its filters load: [`CataloguedTechnique::filter_loads`].
    pub filter_loads: fn(&dyn FilterKernel) -> Option<u32>,
    /// Frequency of random scenes with it, relative to a technique with 1.
    pub random_weight: u32,
    /// Ranges of the numbers passed to [`CatalogueEntry::random`].
    pub random_parameters: fn() -> Vec<RandomParameter>,
    /// Random settings: [`CataloguedTechnique::random`].
    pub random: fn(map: ShadowMap, numbers: &[f32]) -> TechniquePreset,
    /// True if quick comparisons run it: [`CataloguedTechnique::IS_PREVIEWED`].
    pub is_previewed: bool,
}

/// Shows only the name, since addresses of functions differ from run to run.
impl Debug for CatalogueEntry {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        write!(f, "{}", self.technique.name)
    }
}

impl CatalogueEntry {
    /// Returns the entry of a technique.
    pub fn for_technique<T: CataloguedTechnique>() -> Self {
        Self {
            technique: TechniqueEntry::for_technique::<T>(),
            settings: |map_sizes, fit| presets(T::compared_settings(map_sizes, fit)),
            headline: |map_sizes, fit| presets(T::headline(map_sizes, fit)),
            max_compared_triangles: T::MAX_COMPARED_TRIANGLES,
            exhaustive: |map_size| presets(T::exhaustive(map_size)),
            candidates: |map, light| {
                let candidates = T::candidates(map, light).into_iter();
                candidates.map(|c| c.map(TechniquePreset::from)).collect()
            },
            planned_biases: T::PLANNED_BIASES,
            why_chosen: |preset, error, recipe| preset.get::<T>()?.why_chosen(error, recipe),
            closed_form: |map| {
                let demand = T::closed_form(map)?;
                Some(ClosedFormDemand {
                    technique: TechniquePreset::from(demand.technique),
                    reach: demand.reach,
                    tolerance: demand.tolerance,
                    closed_bodies: demand.closed_bodies,
                })
            },
            kernel_reach: |preset| preset.get::<T>()?.kernel_reach(),
            kernel: T::kernel,
            filter_loads: T::filter_loads,
            random_weight: T::RANDOM_WEIGHT,
            random_parameters: T::random_parameters,
            random: |map, numbers| TechniquePreset::from(T::random(map, numbers)),
            is_previewed: T::IS_PREVIEWED,
        }
    }
}

fn presets<T: CataloguedTechnique>(settings: Vec<T>) -> Vec<TechniquePreset> {
    settings.into_iter().map(TechniquePreset::from).collect()
}

macro_rules! rows {
    ($($technique:ty,)*) => {
        vec![$(CatalogueEntry::for_technique::<$technique>()),*]
    };
}

static BUILT_IN: LazyLock<Vec<CatalogueEntry>> = LazyLock::new(|| for_each_technique!(rows));

/// Returns the entries of all built-in techniques, cheapest first.
pub fn all() -> &'static [CatalogueEntry] {
    &BUILT_IN
}

/// Returns the entry of the built-in technique with this name.
pub fn find(name: &str) -> Option<&'static CatalogueEntry> {
    all().iter().find(|entry| entry.technique.name == name)
}

/// Techniques available to a program: the built-in ones, and its own.
#[derive(Clone, Debug)]
pub struct Catalogue(Vec<CatalogueEntry>);

impl Default for Catalogue {
    fn default() -> Self {
        Self::built_in()
    }
}

/// Compares the names in order.
impl PartialEq for Catalogue {
    fn eq(&self, other: &Self) -> bool {
        self.names() == other.names()
    }
}

impl Catalogue {
    /// Returns the built-in techniques, cheapest first.
    pub fn built_in() -> Self {
        Self(all().to_vec())
    }

    /// Returns the catalogue with one more technique.
    ///
    /// # Errors
    /// Errors if the catalogue has a technique of that name.
    pub fn with(mut self, entry: CatalogueEntry) -> Result<Self, Invalid> {
        if self.find(entry.technique.name).is_some() {
            let why = format!("`{}` is already in the catalogue", entry.technique.name);
            return Err(Invalid::new("technique", why, "give it another name"));
        }
        self.0.push(entry);
        Ok(self)
    }

    /// Returns the catalogue with only the techniques whose names `keep` accepts.
    #[must_use]
    pub fn retain(mut self, keep: impl Fn(&str) -> bool) -> Self {
        self.0.retain(|entry| keep(entry.technique.name));
        self
    }

    /// Returns all entries, in order.
    pub fn all(&self) -> &[CatalogueEntry] {
        &self.0
    }

    /// Returns the entry of the technique with this name.
    pub fn find(&self, name: &str) -> Option<&CatalogueEntry> {
        self.0.iter().find(|entry| entry.technique.name == name)
    }

    /// Returns the reach of lookups with these settings, texels:
    /// [`CataloguedTechnique::kernel_reach`].
    pub fn kernel_reach(&self, preset: &TechniquePreset) -> Option<f32> {
        let entry = self.find(preset.name())?;
        (entry.kernel_reach)(preset)
    }

    /// Returns the measured properties of a recipe's kernel, from the catalogue's own techniques or
    /// a built-in one.
    pub fn kernel<'a>(&self, recipe: &'a Recipe) -> &'a dyn CataloguedKernel {
        let kernel = &*recipe.receive.kernel;
        let known = self
            .all_and_built_in()
            .find_map(|entry| (entry.kernel)(kernel));
        known.unwrap_or(&UnknownKernel)
    }

    /// Returns the number of texels that a filter loads for each that it writes, from the
    /// catalogue's own techniques or a built-in one.
    pub fn filter_loads(&self, filter: &dyn FilterKernel) -> u32 {
        let known = self
            .all_and_built_in()
            .find_map(|entry| (entry.filter_loads)(filter));
        known.unwrap_or(1)
    }

    fn all_and_built_in(&self) -> impl Iterator<Item = &CatalogueEntry> {
        self.0.iter().chain(all())
    }

    /// Returns all names, in order.
    pub fn names(&self) -> Vec<&'static str> {
        self.0.iter().map(|entry| entry.technique.name).collect()
    }

    /// Returns the techniques with these names in the catalogue's order, or all if no names are
    /// given.
    ///
    /// # Errors
    /// Errors if no technique has one of the names.
    pub fn select(&self, names: &[String]) -> Result<Vec<&CatalogueEntry>, Invalid> {
        if let Some(unknown) = names.iter().find(|name| self.find(name).is_none()) {
            let why = format!("`{unknown}` is unknown");
            let help = format!("use some of {}", self.names().join(", "));
            return Err(Invalid::new("technique", why, help));
        }
        let wanted = |entry: &&CatalogueEntry| {
            names.is_empty() || names.iter().any(|n| n == entry.technique.name)
        };
        Ok(self.0.iter().filter(wanted).collect())
    }

    /// Reads a preset of one of these techniques from TOML.
    ///
    /// # Errors
    /// Errors if the text is not TOML, names none of these techniques, or has a field unknown to
    /// the technique.
    pub fn preset_from_toml(&self, text: &str) -> Result<TechniquePreset, Invalid> {
        let entries: Vec<TechniqueEntry> = self.0.iter().map(|entry| entry.technique).collect();
        TechniquePreset::read(text, &entries)
    }
}
