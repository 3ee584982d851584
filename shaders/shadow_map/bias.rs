//! Bias: how a receiver is kept from shadowing itself. One piece, taken by every map technique.
//!
//! A shadow map stores one depth a texel, the receiver has another depth at each pixel; where the
//! stored surface slopes away under its own texel, the receiver finds itself behind it (acne).
//! Every cure moves one of the two apart, and detaches shadows from their casters if it moves too
//! far (peter-panning). The cures, all of which may be combined:
//!
//! * **constant**: a fixed clip depth. Right for one slope only.
//! * **slope-scaled receiver bias**: `max(slope (1 - n.l), min)` in clip depth, the textbooks'
//!   `max(.05 (1 - n.l), .005)`.
//! * **polygon offset** ([`RasterBias`]): the rasteriser pushes casters away by their own depth
//!   slope.
//! * **normal offset** (Holbert 2011, "Saying goodbye to shadow acne"): the receiver moves along
//!   its geometric normal by texels times the sine of the light's angle of incidence.
//! * **receiver plane** (Schüler 2006, "Eliminating surface acne with gradient shadow mapping";
//!   Isidoro 2006, "Shadow mapping: GPU-based tips and techniques"): each tap is compared with the
//!   depth that the receiver's plane has at the tap. Analytic here: from the geometric normal, not
//!   from screen-space derivatives.
//! * **both planes** ([`Bias::ADAPTIVE`], the default): see below.
//! * **culling front faces** ([`Cull::Front`]; Wang and Molnar 1994, "Second-depth shadow
//!   mapping"): closed casters store their far side. Leaks at contacts, fails on open casters.
//!
//! # The default
//!
//! Of two things that meet in a texel, the receiver's surface and the stored one, each is known as
//! a plane. Between the receiver, whose depth is z at q, and the texel's centre c, a continuous
//! surface changes its depth by the slopes of the facets that it crosses: by t gₐ·d on the
//! receiver's own facet, and by (1 - t) gₛ·d on the stored one, where d = c - q is at most half a
//! texel along each axis and t is the share of the way on the receiver's. Two corrections, each
//! from one plane, keep such a surface from shadowing itself, however its facets lie:
//!
//! * the depth compared is min(z, z + gₐ·d): that of the receiver's plane at the texel, but never
//!   deeper than the receiver. (The plane alone, Schüler's and Isidoro's rule, says how deep a tap
//!   *would* be if the facet went on to it. Where facets are smaller than texels it doesn't, and a
//!   neighbour that is nearer than the plane, but deeper than the receiver, is taken for a blocker.
//!   What is deeper than the receiver at the texel can't hide it unless it slopes.)
//! * casters move away by half a texel of their own slope (a polygon offset of .5): what the stored
//!   facet may gain between the texel's centre and its rim.
//!
//! Of -(t gₐ + (1 - t) gₛ)·d nothing is left that the second doesn't take off where the stored
//! facet slopes along one axis. (A polygon offset counts the steeper axis alone, so along the
//! diagonal it would take twice as much to be sure.) Kernels that reach r texels farther meet
//! facets that neither plane knows: .25 r texels of slope more do best over the built-in scenes and
//! scanned models; comparison samples, each of which compares one depth with four texels, take 2 in
//! all. Neither half detaches a shadow by more than about a texel's gain of the surface that it
//! belongs to, and both are many times what rasterisers are off that snap vertices to 1/16 texel
//! (1/32 texel's gain), the coarsest that Vulkan allows. The CPU's models of coarser grids bear
//! that out (`tests/suite/coarse_grids.rs`). `cargo xtask bias` compares it with the best of all
//! others on any scene.
//!
//! Known failures: comparison samples take the whole margin from the stored facet, so where a steep
//! facet meets a flatter one at a convex edge, the flatter one's margin is too small and the steep
//! one is up to some percent grey within a texel of the edge ([`Bias::RECEIVER_PLANE`] has none of
//! that, and errs more on finely tessellated models). At grazing light no finite constant is
//! enough; the offset of slope and normal grows past thin casters; the receiver's plane alone says
//! nothing about a neighbouring triangle with another slope, so that under a low sun hills get acne
//! along their creases, and finely tessellated models all over. Far from the origin positions are
//! rounded: under directional light the constants of normal offset and receiver's plane grow with
//! that, and shadows start as far behind their casters; lamps get acne there (shapes of a metre
//! from a kilometre on). Constant and slope-scaled biases are clip depth: under a lamp, whose clip
//! depth is crowded near it, they lose casters close to the lamp, and shadows start centimetres
//! behind thin plates.

#[cfg(doc)]
use umbrage_core::Snapping;
use umbrage_core::{Cull, Invalid, RasterBias, invalid};

/// All slopes that a light space can hold: from its near to its far plane within a texel.
const STEEPEST: f32 = 1.0;
/// Texels of their own slope by which [`Bias::ADAPTIVE`] moves casters for one comparison: half the
/// texel's side.
const CASTER_TEXELS: f32 = 0.5;
/// Texels of slope more for each texel that a kernel reaches: measured (`cargo xtask bias`).
const CASTER_TEXELS_PER_REACH: f32 = 0.25;
/// The same for comparison samples, each of which compares one depth with four texels up to a texel
/// away along both axes: over that way a plane gains at most twice what it gains along its steeper
/// axis, which is what a polygon offset counts.
const CASTER_TEXELS_OF_SAMPLES: f32 = 2.0;

/// The same where taps follow the receiver's plane alone, so that what is compared is equal but for
/// rounding. The coarsest rasterisers ([`Snapping::COARSEST`]) store depths of a place that is up
/// to half a step of their grid away along both axes, so by a step, 1/16 texel, of the steeper
/// slope. Twice that, since some lay one plane through three corners of a clipped polygon: what
/// lies beyond the three is farther off.
const CASTER_TEXELS_BESIDE_THE_PLANE: f32 = 0.125;

/// How a kernel compares receivers with the map, as far as [`Bias::ADAPTIVE`] depends on it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum CompareMethod {
    /// With single texels.
    Taps {
        /// How far they reach beyond the receiver's own texel, texels.
        reach: f32,
    },
    /// With comparison samples, each of which blends the answers of 2x2 texels.
    Samples,
}

/// The bias of a map technique. `Default` is none at all.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(
    feature = "presets",
    derive(serde::Serialize, serde::Deserialize),
    serde(default, deny_unknown_fields)
)]
pub struct Bias {
    /// Clip depth, 0 to 1; subtracted from the receiver's depth. Where the bias also moves the
    /// receiver or its taps (normal offset, receiver's plane), this is for rounding: under
    /// directional light it is at least what positions so far from the origin are rounded by.
    pub constant: f32,
    /// Clip depth at grazing light: the receiver's depth loses `max(slope (1 - n.l), slope_min)`.
    pub slope: f32,
    /// Clip depth, the least that the slope term takes off.
    pub slope_min: f32,
    /// Polygon offset of the casters.
    pub raster: RasterBias,
    /// Texels along the receiver's normal at grazing light; scaled by the sine of the angle of
    /// incidence.
    pub normal_offset: f32,
    /// Greatest depth slope, clip depth a texel, that taps follow along the receiver's plane; 0
    /// switches it off.
    pub receiver_plane: f32,
    /// Both planes, the receiver's and the stored surface's: see the module's page. Beside it
    /// `receiver_plane` has no meaning, and `raster` is added to the casters' half of it.
    pub adaptive: bool,
    /// Casters' faces left out.
    pub cull: Cull,
}

impl Bias {
    /// Nothing: shows acne.
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
    /// The default of all map techniques but those that cull front faces: both planes, without a
    /// number that depends on the scene. The constant of 1e-5 covers the rounding of depths.
    pub const ADAPTIVE: Self = Self {
        adaptive: true,
        constant: 1e-5,
        ..Self::NONE
    };
    /// The textbooks' constant bias of .005.
    pub const CONSTANT: Self = Self {
        constant: 0.005,
        ..Self::NONE
    };
    /// The textbooks' slope-scaled bias, `max(.05 (1 - n.l), .005)`.
    pub const SLOPE: Self = Self {
        slope: 0.05,
        slope_min: 0.005,
        ..Self::NONE
    };
    /// The textbooks' polygon offset: slope factor 2, 4 units.
    pub const POLYGON_OFFSET: Self = Self {
        raster: RasterBias {
            constant: 4,
            slope: 2.0,
            clamp: 0.0,
        },
        ..Self::NONE
    };
    /// The normal offset that one comparison needs: see [`Bias::normal_offset`].
    pub const NORMAL_OFFSET: Self = Self::normal_offset(0.0);
    /// Isidoro's receiver's plane, up to a slope of .1 a texel, and 1e-5 for the rounding of
    /// depths. Casters move away by 1/8 texel of their slope, for the rounding of vertices.
    pub const RECEIVER_PLANE: Self = Self {
        receiver_plane: 0.1,
        constant: 1e-5,
        ..Self::NONE
    };
    /// Front faces of the casters left out.
    pub const FRONT_CULL: Self = Self {
        cull: Cull::Front,
        ..Self::NONE
    };

    /// The named settings above.
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

    /// The least normal offset that frees a plane of acne, for a kernel that reaches `reach` texels
    /// beyond the receiver's own: a tap's centre is up to `reach + .5` texels away along each axis,
    /// so (reach + .5) sqrt(2) in all; over a distance d, a plane at angle t to the light gains
    /// depth d tan(t), and moving the receiver by o sin(t) along its normal takes off o tan(t). The
    /// constant of 1e-5 covers the rounding of depths.
    pub const fn normal_offset(reach: f32) -> Self {
        Self {
            normal_offset: (reach + 0.5) * std::f32::consts::SQRT_2,
            constant: 1e-5,
            ..Self::NONE
        }
    }

    /// The least polygon offset that frees a plane of acne, for the same reach: depth grows by at
    /// most m a texel along each of two axes, so by (2 reach + 1) m to the farthest tap. Four
    /// units, as in the textbooks, cover rounding.
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

    /// Returns whether the constant is there for rounding alone, since the rest of the bias moves
    /// the receiver or its taps as far as the geometry requires.
    pub(crate) fn covers_rounding(&self) -> bool {
        self.constant > 0.0
            && (self.adaptive || self.receiver_plane > 0.0 || self.normal_offset > 0.0)
    }

    /// Returns the greatest depth slope that taps follow, clip depth a texel; 0 where they follow
    /// none.
    pub(crate) fn plane_limit(&self) -> f32 {
        if self.adaptive {
            STEEPEST
        } else {
            self.receiver_plane
        }
    }

    /// Returns the polygon offset of the casters, with what the bias adds for this kind of
    /// comparison.
    pub(crate) fn raster_for(&self, compare: CompareMethod) -> RasterBias {
        let texels = match compare {
            CompareMethod::Taps { reach } => CASTER_TEXELS + CASTER_TEXELS_PER_REACH * reach,
            CompareMethod::Samples => CASTER_TEXELS_OF_SAMPLES,
        };
        let margin = match (self.adaptive, self.receiver_plane > 0.0) {
            (true, _) => texels,
            (false, true) => CASTER_TEXELS_BESIDE_THE_PLANE,
            (false, false) => 0.0,
        };
        RasterBias {
            slope: self.raster.slope + margin,
            ..self.raster
        }
    }

    /// Returns a few words for tables: a preset's name, or the fields that are set.
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
