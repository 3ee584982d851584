//! The kinds of fit.

use crate::light_space::Extents;
use glam::Vec3;

/// How light spaces are laid around a scene.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(rename_all = "snake_case", deny_unknown_fields)
)]
pub enum Fit {
    /// Culled to need: as tight as it goes without changing any shadow. Of the casters, only those
    /// count that can shadow a seen receiver; sideways the map covers what they share with what is
    /// seen to receive, in depth it runs from the first of them to the last seen receiver. A spot's
    /// map covers no more of its cone than that, other lamps need a cube only if that surrounds
    /// them.
    ///
    /// What is seen is [`View::receivers`](crate::View::receivers); all receivers where those are
    /// unknown. Triangles of which only a box is known are not culled. Bias may move receivers away
    /// from the light by 1/64 of the map's range or more.
    #[default]
    Tight,
    /// As tight as it goes around all that casts and receives, seen or not: it stands still while
    /// the camera moves, and wastes texels on what nobody sees.
    Whole,
    /// For moving cameras, without shimmer: of directional light, a map around the bounding sphere
    /// of what the camera may see up to a distance; it neither turns nor grows with the camera, and
    /// moves by whole texels (Valient 2008, "Stable rendering of cascaded shadow maps"). Where the
    /// sphere around all casters, or all receivers, is smaller, that one counts, and the map stands
    /// still. The depth range, too, changes in rare large steps.
    ///
    /// The sphere's size depends on the camera's projection: shadows shimmer while a field of view
    /// changes, and while the light turns. Lamps stand still, so theirs is [`Fit::Whole`].
    Stable {
        /// How far from the camera shadows are wanted, metres along its view. Beyond, everything is
        /// lit.
        range: f32,
    },
    /// As [`Fit::Stable`], but the sphere is around the camera itself, and the map moves in steps
    /// of a 32nd of its side. So a camera that turns moves no map, and one that walks moves it
    /// seldom: a renderer that keeps maps while they stay draws nothing again.
    ///
    /// For that its texels are larger: with a camera that sees 52 degrees up and 81 across they are
    /// 1.5 times as wide as those of [`Fit::Stable`]. It stays only where
    /// [`Split::Receivers`](crate::Split::Receivers) doesn't cut by what is seen.
    AroundCamera {
        /// How far from the camera shadows are wanted, metres along its view. Beyond, everything is
        /// lit.
        range: f32,
    },
    /// Textbook style: from `eye` along the light, with explicit extents. Perspective lights use
    /// `near` and `far` alone.
    Manual {
        /// Where depth is counted from, world space. Lights with a position use theirs instead.
        eye: Vec3,
        /// The volume, in the light's view space.
        extents: Extents,
    },
}
