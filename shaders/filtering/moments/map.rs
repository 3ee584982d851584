//! The settings that all maps of moments share, and the images and filters that make one.

use crate::{
    filtering::moments::{
        blur::BoxBlurKernel,
        halve::HalveKernel,
        mipmaps::{self, MipmapUniforms, level_reach, level_side, level_start},
        of_depth::{MomentKind, MomentsKernel},
        stored::{Encoding, MomentPrecision},
    },
    shadow_map::{CompareMethod, MapFormat, ShadowMap, layers::ShadowMapUniforms},
};
use glam::UVec2;
use std::sync::Arc;
use umbrage_core::{ImageDesc, Invalid, ReceiveKernel, Recipe, RecipeError, View};

/// Greatest blur accepted, texels to each side: sums of 65 squares of the steepest exponential are
/// still finite.
pub const MAX_BLUR: u32 = 32;

/// Greatest light-bleeding reduction: beyond, nothing is left of penumbrae.
pub const MAX_BLEEDING_REDUCTION: f32 = 0.95;

/// How much of the light is taken for bleeding.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct BleedingReduction {
    /// What counts as dark, 0..1.
    pub(crate) amount: f32,
    /// What the rest is stretched by: 1 / (1 - amount).
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

/// Which moments a map holds, and how.
#[derive(Clone, Copy, Debug)]
pub(crate) struct MomentImages {
    pub(crate) kind: MomentKind,
    pub(crate) precision: MomentPrecision,
    /// Texels to each side that are averaged.
    pub(crate) blur: u32,
    /// Levels beyond the first, as far as the map is large enough for them.
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

    /// Returns what the channels of the images are.
    pub(crate) fn encoding(&self) -> Encoding {
        self.kind.encoding(self.precision)
    }

    /// Returns the recipe of a technique that looks up such moments of the depths in `map`, with
    /// the kernel that `kernel` makes of the map's uniforms.
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
        if blur > MAX_BLUR {
            let why = format!("is {blur} texels");
            return Err(Invalid::new("blur", why, format!("use 0 to {MAX_BLUR}")).into());
        }
        mipmaps::check_count(mipmaps)?;
        let levels = mipmaps::levels(mipmaps, map.size);
        let spaces = map.spaces(view, blur as f32 + level_reach(levels))?;
        // A blend of blurred depths of a plane is the plane's depth at the receiver, so the blur
        // asks for no more room than one texel.
        let mut maps = map.maps(&spaces, CompareMethod::Taps { reach: 0.0 });
        let desc = |label| ImageDesc {
            label,
            size: UVec2::splat(map.size),
            layers: spaces.spaces.len() as u32,
            format: kind.format(precision),
        };
        let packed = map.format == MapFormat::Rgba8;
        let moments = maps.image(desc("moments"));
        let of_depth = MomentsKernel::new(kind, precision, packed);
        maps.filter(Arc::new(of_depth), vec![maps.map], moments);
        // What is averaged along rows, for the blur and then for the levels.
        let mut rows = None;
        if blur > 0 {
            let rows = *rows.insert(maps.image(desc("moments blurred along rows")));
            let along_rows = BoxBlurKernel::along_rows(blur, self.encoding());
            maps.filter(Arc::new(along_rows), vec![moments], rows);
            let along_columns = BoxBlurKernel::along_columns(blur, self.encoding());
            maps.filter(Arc::new(along_columns), vec![rows], moments);
        }
        maps.map = moments;
        let mut coarser = None;
        if levels > 0 {
            let rows = rows.unwrap_or_else(|| maps.image(desc("moments averaged along rows")));
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
        let lookup = ShadowMapUniforms::new(map, view, &spaces);
        let mut recipe = maps.recipe(kernel(lookup, MipmapUniforms::new(levels, view.camera)));
        recipe.receive.inputs.extend(coarser);
        Ok(recipe)
    }
}
