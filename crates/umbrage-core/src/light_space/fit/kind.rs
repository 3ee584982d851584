//! The kinds of fit.

use crate::light_space::Extents;
use glam::Vec3;

/// Fit of light spaces to a scene.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(rename_all = "snake_case", deny_unknown_fields)
)]
pub enum Fit {
    /// The tightest fit that changes no shadow, as far as the [`View`](crate::View) shows which
    /// casters and receivers there are:
    ///
    /// * With [`View::receivers`](crate::View::receivers), only casters that can shadow a visible
    ///   receiver count. Laterally, the map covers the intersection of these casters and the
    ///   visible receivers. In depth, it begins at the first of these casters and ends at the last
    ///   visible receiver. A spot light's map is limited to that part of its cone. Other lights
    ///   with a position need a cube only if that part surrounds them.
    /// * With [`View::geometry`](crate::View::geometry) alone, all receivers count as visible.
    /// * With [`View::casters`](crate::View::casters) alone, nothing is culled: a map equals that
    ///   of [`Fit::Whole`]. Only cascades are smaller, because each covers a slice of the camera's
    ///   view. This is the case in a `LightSet` whose frames have no geometry.
    ///
    /// A bias may move receivers away from the light by 1/64 of the map's range or more.
    #[default]
    Tight,
    /// The tightest fit around all casters and receivers, visible or not. The map doesn't move with
    /// the camera, but wastes texels on invisible areas.
    Whole,
    /// For moving cameras, without shimmer. For directional light, the map covers the bounding
    /// sphere of the camera's view up to a distance. The map neither turns nor grows with the
    /// camera, and moves by whole texels (Valient 2008, "Stable rendering of cascaded shadow
    /// maps"). If the sphere around all casters, or all receivers, is smaller, that one is used,
    /// and the map doesn't move. The depth range, too, changes in rare large steps.
    ///
    /// The sphere's size depends on the camera's projection: shadows shimmer while the field of
    /// view changes, and while the light turns. Lights with a position don't move with the camera
    /// and use [`Fit::Whole`].
    Stable {
        /// Shadow distance, metres along the camera's view. Everything beyond is lit.
        range: f32,
    },
    /// Like [`Fit::Stable`], but the sphere is around the camera itself, and the map moves in steps
    /// of a 32nd of its side. The map does not move when the camera turns, and rarely when it
    /// walks. A renderer that caches maps then redraws nothing.
    ///
    /// The cost is larger texels. With a field of view of 52 degrees vertically and 81
    /// horizontally, they are 1.5 times as wide as those of [`Fit::Stable`]. The map isn't stable
    /// with [`Split::Receivers`](crate::Split::Receivers), which follows the visible receivers.
    AroundCamera {
        /// Shadow distance, metres along the camera's view. Everything beyond is lit.
        range: f32,
    },
    /// Manual fit: from `eye` along the light, with explicit extents. Perspective lights use only
    /// `near` and `far`.
    Manual {
        /// Origin of depth, world space. Lights with a position use their own instead.
        eye: Vec3,
        /// The volume, in the light's view space.
        extents: Extents,
    },
}
