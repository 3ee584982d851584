//! Common settings of all moment maps, and the images and filters of one.

use crate::{
    filtering::moments::{
        blur::MomentMapKernel,
        halve::HalveKernel,
        mipmaps::{self, MipmapUniforms, level_reach, level_side, level_start},
        of_depth::MomentKind,
        stored::{Encoding, MomentPrecision},
    },
    shadow_map::{CompareMethod, MapFormat, ShadowMap, layers::ShadowMapUniforms},
};
use glam::UVec2;
use std::sync::Arc;
use umbrage_core::{ImageDesc, Invalid, ReceiveKernel, Recipe, RecipeError, View};

/// Greatest blur radius, texels. Sums of 65 squares of the steepest exponential are still finite.
pub const MAX_BLUR: u32 = 32;

/// Greatest light-bleeding reduction; beyond it, penumbrae vanish.
pub const MAX_BLEEDING_REDUCTION: f32 = 0.95;

/// Light-bleeding reduction.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct BleedingReduction {
    /// Fraction of light that counts as dark, 0..1.
    pub(crate) amount: f32,
    /// Stretch factor of the rest: 1 / (1 - amount).
    pub(crate) scale: f32,
}

impl BleedingReduction {
    /// # Errors
    /// Errors if the amount isn't within 0 to [`MAX_BLEEDING_REDUCTION`].
    pub(crate) fn new(amount: f32) -> Result<Self, Invalid> {
        check(
            "light-bleeding reduction",
            amount,
            0.0,
            MAX_BLEEDING_REDUCTION,
        )?;
        Ok(Self {
            amount,
            scale: 1.0 / (1.0 - amount),
        })
    }

    /// Returns the reduction for light of which `1.0 - bias` comes from the map, and the rest from
    /// depths that don't belong to it, 0..=1.
    ///
    /// A bound of the mixture's light divided by `1.0 - bias` bounds the map's light, since the
    /// rest is dark at worst. So receivers before an empty map are fully lit. The uniforms contain
    /// this quotient: (l / (1 - b) - a) / (1 - a) is (l - a (1 - b)) / ((1 - a) (1 - b)).
    pub(crate) fn with_moment_bias(self, bias: f32) -> Self {
        // A bias of 1 leaves nothing of the map. Then the least divisor keeps the scale finite.
        let share = (1.0 - bias).max(f32::EPSILON);
        Self {
            amount: self.amount * share,
            scale: self.scale / share,
        }
    }
}

/// Checks that a number of the settings is within its range.
///
/// # Errors
/// Errors if it isn't, or is no number.
pub(crate) fn check(what: &str, value: f32, least: f32, most: f32) -> Result<(), Invalid> {
    if (least..=most).contains(&value) {
        return Ok(());
    }
    let why = format!("is {value}");
    Err(Invalid::new(what, why, format!("use {least} to {most}")))
}

/// Checks a least standard deviation of depth, clip depth: half of the map's range at most.
///
/// # Errors
/// Errors if it is more, negative, or no number.
pub(crate) fn check_deviation(least: f32) -> Result<(), Invalid> {
    check("least deviation", least, 0.0, 0.5)
}

/// Kind and format of a map's moments.
#[derive(Clone, Copy, Debug)]
pub(crate) struct MomentImages {
    pub(crate) kind: MomentKind,
    pub(crate) precision: MomentPrecision,
    /// Number of texels on each side that are averaged.
    pub(crate) blur: u32,
    /// Number of levels beyond the first, limited by the map's size.
    pub(crate) mipmaps: u32,
}

impl MomentImages {
    /// Returns the settings in words: `blur 7x7`, `2 mipmaps`, `16 bits`.
    pub(crate) fn words(&self) -> Vec<String> {
        let side = 2 * u64::from(self.blur) + 1;
        let mut words = vec![format!("blur {side}x{side}")];
        match self.mipmaps {
            0 => {}
            1 => words.push("1 mipmap".to_owned()),
            count => words.push(format!("{count} mipmaps")),
        }
        if self.precision == MomentPrecision::Bits16 {
            words.push("16 bits".to_owned());
        }
        words
    }

    /// Returns the encoding of the images' channels.
    pub(crate) fn encoding(&self) -> Encoding {
        self.kind.encoding(self.precision)
    }

    /// Returns the recipe of a technique that looks up these moments of the depths in `map`.
    /// `kernel` builds its kernel from the map's uniforms.
    ///
    /// # Errors
    /// Errors if [`ShadowMap::spaces`] does, or the blur is too wide.
    pub(crate) fn recipe<K: ReceiveKernel + 'static>(
        self,
        map: &ShadowMap,
        view: &View<'_>,
        kernel: impl FnOnce(ShadowMapUniforms, MipmapUniforms) -> K,
    ) -> Result<Recipe, RecipeError> {
        let Self {
            kind,
            precision,
            blur,
            mipmaps,
        } = self;
        // Check the settings.
        if blur > MAX_BLUR {
            let why = format!("is {blur} texels");
            return Err(Invalid::new("blur", why, format!("use 0 to {MAX_BLUR}")).into());
        }
        mipmaps::check_count(mipmaps)?;
        let levels = mipmaps::levels(mipmaps, map.size);
        let spaces = map.spaces(view, blur as f32 + level_reach(levels))?;
        // Reserve one texel only: blending blurred depths of a plane gives the plane's depth at the
        // receiver, so the blur needs no additional margin.
        let mut maps = map.maps(&spaces, CompareMethod::Taps { reach: 0.0 });
        let desc = |label| ImageDesc {
            label,
            size: UVec2::splat(map.size),
            layers: spaces.spaces.len() as u32,
            format: kind.format(precision),
        };
        // Convert depths to blurred moments.
        let packed = map.format == MapFormat::Rgba8;
        let moments = maps.image(desc("moments"));
        let of_depth = MomentMapKernel::new(kind, precision, blur, packed);
        maps.filter(Arc::new(of_depth), vec![maps.map], moments);
        maps.map = moments;
        // Add the mipmap levels.
        let mut coarser = None;
        if levels > 0 {
            let rows = maps.image(desc("moments averaged along rows"));
            let along_rows = HalveKernel::along_rows(levels, self.encoding());
            maps.filter(Arc::new(along_rows), vec![moments], rows);
            let below_each_other = ImageDesc {
                size: UVec2::new(level_side(map.size, 1), level_start(map.size, levels + 1)),
                ..desc("mipmaps of moments")
            };
            let image = maps.image(below_each_other);
            let along_columns = HalveKernel::along_columns(levels, self.encoding());
            maps.filter(Arc::new(along_columns), vec![rows], image);
            coarser = Some(image);
        }
        // Add the lookup.
        let lookup = ShadowMapUniforms::new(map, view, &spaces);
        let mut recipe = maps.recipe(kernel(lookup, MipmapUniforms::new(levels, view.camera)));
        recipe.receive.inputs.extend(coarser);
        Ok(recipe)
    }
}
