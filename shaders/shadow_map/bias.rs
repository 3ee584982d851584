//! Bias settings, which keep receivers from shadowing themselves. All map techniques share them.
//!
//! A shadow map stores one depth per texel, but the receiver's depth varies from pixel to pixel. If
//! the stored surface slopes away within its texel, the receiver may be behind it (acne). Each
//! remedy moves the receiver or the caster. Moving too far detaches shadows from their casters
//! (peter-panning). The remedies can be combined:
//!
//! - **constant**: a fixed clip depth. It is right for one slope only.
//! - **slope-scaled receiver bias**: `max(slope (1 - n.l), min)` in clip depth, the textbooks'
//!   `max(.05 (1 - n.l), .005)`.
//! - **polygon offset** ([`RasterBias`]): the rasteriser moves casters away by their own depth
//!   slope.
//! - **normal offset** (Holbert 2011, "Saying goodbye to shadow acne"): the receiver moves along
//!   its geometric normal by texels times the sine of the light's angle of incidence.
//! - **receiver plane** (Schüler 2006, "Eliminating surface acne with gradient shadow mapping";
//!   Isidoro 2006, "Shadow mapping: GPU-based tips and techniques"): each tap is compared with the
//!   depth of the receiver's plane at the tap. The plane is computed analytically from the
//!   geometric normal, not from screen-space derivatives.
//! - **both planes** ([`Bias::ADAPTIVE`], the default): see below.
//! - **culling front faces** ([`Cull::Front`]; Wang and Molnar 1994, "Second-depth shadow
//!   mapping"): closed casters store their far side. Leaks at contacts, fails on open casters.
//!
//! # The default
//!
//! Each texel compares two surfaces, the receiver's and the stored one. Both are known as planes.
//! Let z be the receiver's depth at q, c the texel's centre, and d = c - q, at most half a texel
//! along each axis. Along d, the depth of a continuous surface changes by the slopes of the facets
//! that it crosses: by t gₐ·d on the receiver's facet, and by (1 - t) gₛ·d on the stored one. Here
//! t is the fraction of the way that is on the receiver's facet. Two corrections, each derived from
//! one plane, keep such a surface from shadowing itself for any arrangement of its facets:
//!
//! - The compared depth is min(z, z + gₐ·d): the depth of the receiver's plane at the texel, but
//!   never deeper than the receiver. The plane alone, Schüler's and Isidoro's rule, gives the depth
//!   that a tap *would* have if the facet extended to it. Facets smaller than texels don't. Then a
//!   neighbour between the plane and the receiver's depth is mistaken for a blocker. A surface
//!   deeper than the receiver at the texel can't hide it unless that surface slopes.
//! - Casters move away by half a texel of their own slope (a polygon offset of .5). This is the
//!   most that the stored facet can gain between the texel's centre and its edge.
//!
//! The second correction removes the remaining -(t gₐ + (1 - t) gₛ)·d if the stored facet slopes
//! along one axis. A polygon offset uses only the steeper axis, so a guarantee along the diagonal
//! would need twice as much. Kernels that reach r texels farther meet facets that neither plane
//! describes. An additional .25 r texels of slope is best over the built-in scenes and scanned
//! models. Comparison samples, each of which compares one depth with four texels, use 2 texels in
//! total.
//!
//! Neither correction detaches a shadow by more than about one texel's gain of its surface. Both
//! greatly exceed the error of rasterisers that snap vertices to 1/16 texel (1/32 texel's gain),
//! the coarsest grid that Vulkan allows. Tests with the CPU's models of coarser grids confirm this
//! (`tests/suite/coarse_grids.rs`). `cargo xtask bias` compares this bias with the best of all
//! others on any scene.
//!
//! Known failures:
//!
//! - Kernels that reach r texels need .5 + r texels of the stored slope where casters are smaller
//!   than a texel: all taps but one meet the ground behind the caster, which neither plane
//!   describes. The default has .5 + .25 r, so that the sides of a box on a ground of kilometres
//!   are a third dark (pcf 3x3, one map). `raster.slope = .75 r` on top removes this, but costs
//!   more elsewhere: see `docs/bias.md`. Use cascades.
//! - Comparison samples take the whole margin from the stored facet. Where a steep facet meets a
//!   flatter one at a convex edge, the flatter one's margin is too small. The steep facet is then
//!   up to some percent grey within a texel of the edge. [`Bias::RECEIVER_PLANE`] avoids this, but
//!   has larger errors on finely tessellated models.
//! - At grazing light no finite constant is enough, and the offset of slope and normal exceeds the
//!   thickness of thin casters.
//! - The receiver's plane alone does not describe a neighbouring triangle with another slope. Under
//!   a low sun, hills get acne along their creases, and finely tessellated models everywhere.
//! - Far from the origin positions are rounded. Under directional light the constants of normal
//!   offset and receiver plane grow accordingly, and shadows start that far behind their casters.
//!   Lights with a position get acne there (shapes of a metre from a kilometre on).
//! - Constant and slope-scaled biases are clip depth, which a light with perspective concentrates
//!   near itself. They lose casters close to the light, and shadows start centimetres behind thin
//!   plates.

#[cfg(doc)]
use umbrage_core::Snapping;
use umbrage_core::{Cull, Invalid, RasterBias, invalid};

/// Upper bound of all slopes in a light space: from its near to its far plane within a texel.
const STEEPEST: f32 = 1.0;
/// Texels of their own slope by which [`Bias::ADAPTIVE`] moves casters for one comparison: half the
/// texel's side.
const CASTER_TEXELS: f32 = 0.5;
/// Additional texels of slope per texel of kernel reach; measured with `cargo xtask bias`.
const CASTER_TEXELS_PER_REACH: f32 = 0.25;
/// Texels of slope for comparison samples, each of which compares one depth with four texels. These
/// are up to a texel away along both axes. Over that distance a plane gains at most twice the slope
/// of its steeper axis, which is the slope that a polygon offset uses.
const CASTER_TEXELS_OF_SAMPLES: f32 = 2.0;

/// Texels of slope for taps that follow only the receiver's plane, where the compared depths differ
/// only by rounding. The coarsest rasterisers ([`Snapping::COARSEST`]) store the depth of a point
/// up to half a grid step away along both axes. That is the steeper slope times one step, 1/16
/// texel. The value is twice that, since some rasterisers use one plane through three corners of a
/// clipped polygon and are less accurate beyond the three.
const CASTER_TEXELS_OFF_PLANE: f32 = 0.125;

/// Comparison method of a kernel, as far as [`Bias::ADAPTIVE`] depends on it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum CompareMethod {
    /// Comparisons with single texels.
    Taps {
        /// Reach beyond the receiver's own texel, texels.
        reach: f32,
    },
    /// Comparison samples, each of which blends the results of 2x2 texels.
    Samples,
}

/// Bias of a map technique. The `Default` is no bias.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(
    feature = "presets",
    derive(serde::Serialize, serde::Deserialize),
    serde(default, deny_unknown_fields)
)]
pub struct Bias {
    /// Clip depth, 0 to 1, that is subtracted from the receiver's depth. If the bias also moves the
    /// receiver or its taps (normal offset, receiver plane), this covers rounding. Under
    /// directional light it is then at least the rounding error of positions at that distance from
    /// the origin.
    pub constant: f32,
    /// Clip depth at grazing light: the receiver's depth loses `max(slope (1 - n.l), slope_min)`.
    pub slope: f32,
    /// Clip depth, the lower bound of the slope term.
    pub slope_min: f32,
    /// Polygon offset of the casters.
    pub raster: RasterBias,
    /// Receiver offset along its normal at grazing light, texels; scaled by the sine of the angle
    /// of incidence.
    pub normal_offset: f32,
    /// Greatest depth slope, clip depth per texel, that taps follow along the receiver's plane; 0
    /// disables it.
    pub receiver_plane: f32,
    /// Uses both planes, the receiver's and the stored surface's: see the module documentation.
    /// Overrides `receiver_plane`; `raster` is added to the offset of the casters.
    pub adaptive: bool,
    /// Culled faces of casters.
    pub cull: Cull,
}

impl Bias {
    /// No bias, which shows acne.
    pub const NONE: Self = Self {
        constant: 0.0,
        slope: 0.0,
        slope_min: 0.0,
        raster: RasterBias {
            constant: 0,
            slope: 0.0,
            clamp: 0.0,
        },
        normal_offset: 0.0,
        receiver_plane: 0.0,
        adaptive: false,
        cull: Cull::None,
    };
    /// Default of all map techniques except those that cull front faces. Uses both planes and no
    /// number that depends on the scene. The constant of 1e-5 covers the rounding of depths.
    /// With perspective it is at most 1/256 of the near plane's distance over the far plane's.
    pub const ADAPTIVE: Self = Self {
        adaptive: true,
        constant: 1e-5,
        ..Self::NONE
    };
    /// Constant bias of the textbooks, .005.
    pub const CONSTANT: Self = Self {
        constant: 0.005,
        ..Self::NONE
    };
    /// Slope-scaled bias of the textbooks, `max(.05 (1 - n.l), .005)`.
    pub const SLOPE: Self = Self {
        slope: 0.05,
        slope_min: 0.005,
        ..Self::NONE
    };
    /// Polygon offset of the textbooks: slope factor 2, 4 units.
    pub const POLYGON_OFFSET: Self = Self {
        raster: RasterBias {
            constant: 4,
            slope: 2.0,
            clamp: 0.0,
        },
        ..Self::NONE
    };
    /// Normal offset that one comparison needs: see [`Bias::normal_offset`].
    pub const NORMAL_OFFSET: Self = Self::normal_offset(0.0);
    /// Isidoro's receiver plane, up to a slope of .1 per texel, and 1e-5 for the rounding of
    /// depths. Casters move away by 1/8 texel of their slope, for the rounding of vertices.
    pub const RECEIVER_PLANE: Self = Self {
        receiver_plane: 0.1,
        constant: 1e-5,
        ..Self::NONE
    };
    /// Culls the front faces of casters.
    pub const FRONT_CULL: Self = Self {
        cull: Cull::Front,
        ..Self::NONE
    };

    /// Named settings above.
    pub const PRESETS: [(&'static str, Self); 8] = [
        ("none", Self::NONE),
        ("adaptive", Self::ADAPTIVE),
        ("constant .005", Self::CONSTANT),
        ("slope .05/.005", Self::SLOPE),
        ("polygon offset 2, 4", Self::POLYGON_OFFSET),
        ("normal offset .71", Self::NORMAL_OFFSET),
        ("receiver plane", Self::RECEIVER_PLANE),
        ("front cull", Self::FRONT_CULL),
    ];

    /// Returns the least normal offset without acne on a plane, for a kernel that reaches `reach`
    /// texels beyond the receiver's own. A tap's centre is up to `reach + .5` texels away along
    /// each axis, so (reach + .5) sqrt(2) in total. Over a distance d, a plane at angle t to the
    /// light gains depth d tan(t). Moving the receiver by o sin(t) along its normal subtracts o
    /// tan(t). The constant of 1e-5 covers the rounding of depths.
    pub const fn normal_offset(reach: f32) -> Self {
        Self {
            normal_offset: (reach + 0.5) * std::f32::consts::SQRT_2,
            constant: 1e-5,
            ..Self::NONE
        }
    }

    /// Returns the least polygon offset without acne on a plane, for a kernel that reaches `reach`
    /// texels beyond the receiver's own. Depth grows by at most m per texel along each of two axes,
    /// so by (2 reach + 1) m to the farthest tap. Four units, as in the textbooks, cover rounding.
    pub const fn polygon_offset(reach: f32) -> Self {
        Self {
            raster: RasterBias {
                constant: 4,
                slope: 2.0 * reach + 1.0,
                clamp: 0.0,
            },
            ..Self::NONE
        }
    }

    /// Returns whether the constant only covers rounding, since the rest of the bias moves the
    /// receiver or its taps as far as the geometry requires.
    pub(crate) fn covers_rounding(&self) -> bool {
        self.constant > 0.0
            && (self.adaptive || self.receiver_plane > 0.0 || self.normal_offset > 0.0)
    }

    /// Returns the greatest depth slope that taps follow, clip depth per texel; 0 if they follow
    /// none.
    pub(crate) fn plane_limit(&self) -> f32 {
        if self.adaptive {
            STEEPEST
        } else {
            self.receiver_plane
        }
    }

    /// Returns the polygon offset of the casters, including what the bias adds for this comparison
    /// method.
    pub(crate) fn raster_for(&self, compare: CompareMethod) -> RasterBias {
        let texels = match compare {
            CompareMethod::Taps { reach } => CASTER_TEXELS + CASTER_TEXELS_PER_REACH * reach,
            CompareMethod::Samples => CASTER_TEXELS_OF_SAMPLES,
        };
        let margin = match (self.adaptive, self.receiver_plane > 0.0) {
            (true, _) => texels,
            (false, true) => CASTER_TEXELS_OFF_PLANE,
            (false, false) => 0.0,
        };
        RasterBias {
            slope: self.raster.slope + margin,
            ..self.raster
        }
    }

    /// Returns a short label for tables: a preset's name, or the fields that are set.
    pub fn label(&self) -> String {
        if let Some((name, _)) = Self::PRESETS.iter().find(|(_, preset)| preset == self) {
            return format!("bias: {name}");
        }
        if *self
            == (Self {
                normal_offset: self.normal_offset,
                ..Self::NORMAL_OFFSET
            })
        {
            return format!("bias: normal offset {:.2}", self.normal_offset);
        }
        let RasterBias {
            constant,
            slope,
            clamp,
        } = self.raster;
        let clamp = if clamp == 0.0 {
            String::new()
        } else {
            format!(" up to {clamp}")
        };
        let fields = [
            (self.constant != 0.0, format!("constant {}", self.constant)),
            (
                self.slope != 0.0 || self.slope_min != 0.0,
                format!("slope {}/{}", self.slope, self.slope_min),
            ),
            (
                self.raster != RasterBias::default(),
                format!("polygon offset {slope}, {constant}{clamp}"),
            ),
            (
                self.normal_offset != 0.0,
                format!("normal offset {:.2}", self.normal_offset),
            ),
            (
                self.receiver_plane != 0.0,
                format!("receiver plane to {}", self.receiver_plane),
            ),
            (self.adaptive, "adaptive".to_owned()),
            (
                self.cull != Cull::None,
                format!("{:?} cull", self.cull).to_lowercase(),
            ),
        ];
        let set: Vec<String> = fields
            .into_iter()
            .filter_map(|(on, text)| on.then_some(text))
            .collect();
        format!("bias: {}", set.join(" + "))
    }

    /// Checks the numbers.
    ///
    /// # Errors
    /// Errors if a number is not finite, or the receiver plane's greatest slope is negative.
    pub fn validate(&self) -> Result<(), Invalid> {
        let RasterBias { slope, clamp, .. } = self.raster;
        invalid::finite(
            "bias",
            &[
                self.constant,
                self.slope,
                self.slope_min,
                slope,
                clamp,
                self.normal_offset,
            ],
        )?;
        invalid::not_negative("receiver plane's greatest slope", self.receiver_plane)
    }
}
