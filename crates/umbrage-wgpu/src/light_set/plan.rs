//! The plan of a light: its recipe, as the set executes it.

use crate::{
    light_set::buffers::{MAX_IMAGES, MAX_IMAGES_WITH_ALL_TABLES, MAX_TABLES},
    wgsl::{kernel::KernelInterface, set::KernelKind},
};
use std::sync::Arc;
use umbrage_core::{
    BackendLimits, Cast, CastMode, CutOuts, DeviceHierarchy, Filter, Invalid, Recipe, RecipeError,
    ShadowTechnique, Source, Table, View,
};

/// Inputs of plans in addition to their view.
#[derive(Clone, Copy, Debug)]
pub(crate) struct PlanInputs<'a> {
    pub(crate) recipes: &'a BackendLimits,
    /// Reason why the device can't build hierarchies of casters, if it can't.
    pub(crate) unbuilt: Option<&'a str>,
    /// Records of the set's alpha-tested casters, if there are any.
    pub(crate) cut_outs: Option<&'a CutOuts>,
}

/// A light's recipe, and the bindings of its kernel.
#[derive(Debug)]
pub(crate) struct LightPlan {
    pub(crate) recipe: Recipe,
    pub(crate) kind: KernelKind,
    /// The kernel's uniforms; empty if it has none.
    pub(crate) uniforms: Vec<u8>,
}

/// Difference between two plans.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Difference {
    Nothing,
    /// Inputs of the kernel other than the maps.
    Numbers,
    /// Contents of the maps.
    Maps,
    /// The set of images, or the kernel that reads them.
    Images,
}

impl LightPlan {
    /// Plans a light. The device builds a hierarchy for techniques that can use one.
    ///
    /// Errors if the technique doesn't support the light, or with `Unsupported` if the set can't
    /// execute its recipe.
    pub(crate) fn of_light(
        technique: &dyn ShadowTechnique,
        view: &View<'_>,
        inputs: PlanInputs<'_>,
    ) -> Result<Self, RecipeError> {
        let device_recipe = technique.device_recipe(view, inputs.cut_outs);
        let recipe = device_recipe.unwrap_or_else(|| technique.recipe(view))?;
        if let (Some(_), Some(why)) = (&recipe.hierarchy, inputs.unbuilt) {
            return Err(RecipeError::unsupported_because(why));
        }
        recipe.validate(inputs.recipes)?;
        Self::new(recipe)
    }

    /// Returns the plan of a valid recipe.
    ///
    /// Errors with `Unsupported` and a reason if the set can't execute it.
    fn new(recipe: Recipe) -> Result<Self, RecipeError> {
        check_casts(&recipe)?;
        // Check the number of bindings.
        let receive = &recipe.receive;
        let kernel = &*receive.kernel;
        let images = receive.inputs.len();
        let tables = receive.tables.len();
        let most_images = if tables < MAX_TABLES {
            MAX_IMAGES
        } else {
            MAX_IMAGES_WITH_ALL_TABLES
        };
        if images > most_images || tables > MAX_TABLES {
            let why = format!(
                "its kernel reads {images} images and {tables} tables, and in a light set it may read {MAX_IMAGES} images with fewer than \
                 {MAX_TABLES} tables, or {MAX_TABLES} tables and {MAX_IMAGES_WITH_ALL_TABLES} image"
            );
            return Err(RecipeError::unsupported_because(why));
        }
        // Describe the kernel.
        let block = kernel.uniforms();
        let kind = KernelKind {
            modules: kernel.modules(),
            uniforms: block.map(|block| {
                let layout = block.uniform_layout();
                (layout.name, layout.size)
            }),
            shape: KernelInterface::new(&recipe, kernel, &receive.inputs, &receive.tables),
            in_compute: kernel.in_compute(),
        };
        let uniforms = block.map_or_else(Vec::new, |block| block.uniform_bytes());
        Ok(Self {
            recipe,
            kind,
            uniforms,
        })
    }

    /// Returns the difference from `before`.
    pub(crate) fn difference(&self, before: &Self) -> Difference {
        let is_like = self.recipe.images == before.recipe.images
            && self.recipe.hierarchy.is_some() == before.recipe.hierarchy.is_some()
            && self.kind == before.kind
            && self.recipe.receive.inputs == before.recipe.receive.inputs;
        if !is_like {
            return Difference::Images;
        }
        let same_maps = all_equal(&self.recipe.casts, &before.recipe.casts, same_cast)
            && all_equal(
                &self.recipe.filters,
                &before.recipe.filters,
                Filter::is_like,
            )
            && all_equal(&self.recipe.tables, &before.recipe.tables, same_table);
        if !same_maps {
            return Difference::Maps;
        }
        if self.uniforms == before.uniforms && self.recipe.hierarchy == before.recipe.hierarchy {
            Difference::Nothing
        } else {
            Difference::Numbers
        }
    }

    /// Returns the kernel's tables that the device doesn't write, which are the last ones.
    pub(crate) fn given_tables(&self) -> impl Iterator<Item = &Table> {
        let written = match self.recipe.hierarchy {
            Some(_) => DeviceHierarchy::TABLES,
            None => 0,
        };
        let given = self.recipe.receive.tables.iter().skip(written);
        given.map(|&table| &self.recipe.tables[table])
    }

    /// Returns the bytes of all images.
    pub(crate) fn bytes(&self) -> u64 {
        self.recipe.image_bytes()
    }
}

/// Errors unless all casts draw casters from the light: other sources depend on one camera's image.
fn check_casts(recipe: &Recipe) -> Result<(), RecipeError> {
    for cast in &recipe.casts {
        let draws_casters = matches!(cast.source, Source::Casters | Source::SomeCasters(_));
        let keeps_depth = !matches!(cast.mode, CastMode::StencilDepthFail { .. });
        if !draws_casters || !keeps_depth {
            return Err(RecipeError::unsupported_because(
                "it draws from the camera, which a light set doesn't support: use `ShadowRenderer`",
            ));
        }
    }
    if recipe.shade.is_some() {
        return Err(Invalid::new(
            "recipe",
            "shades, which a light set doesn't support",
            "plan it without shading",
        )
        .into());
    }
    Ok(())
}

fn all_equal<T>(a: &[T], b: &[T], equal: impl Fn(&T, &T) -> bool) -> bool {
    a.len() == b.len() && a.iter().zip(b).all(|(a, b)| equal(a, b))
}

fn same_cast(a: &Cast, b: &Cast) -> bool {
    // Ignore the recipe's choice of casters: the set determines itself which are visible.
    a.image == b.image
        && a.layer == b.layer
        && a.space == b.space
        && a.mode == b.mode
        && a.cull == b.cull
        && a.bias == b.bias
}

fn same_table(a: &Table, b: &Table) -> bool {
    Arc::ptr_eq(a.rows(), b.rows()) || a.rows() == b.rows()
}
