//! Lights that the user edits.

use serde::{Deserialize, Serialize};
use umbrage::{
    Aabb, Light,
    glam::{Quat, Vec3},
};

/// Greatest number of lights: the length of the forward shader's array.
pub(crate) const MAX_LIGHTS: usize = 16;

/// A light and its appearance.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct EditLight {
    pub light: Light,
    /// Colour in sRGB, 0 to 1.
    pub color: [f32; 3],
    /// Factor of the colour, at least 0.
    pub brightness: f32,
    pub is_on: bool,
}

/// The point that the camera looks at.
#[derive(Clone, Copy, Debug)]
pub(crate) struct LookedAt {
    /// World space, metres.
    pub point: Vec3,
    /// Distance of the markers of directional lights from it, metres.
    pub reach: f32,
}

/// The kinds, in the order of the panel.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub(crate) enum LightKind {
    Directional,
    Spot,
    Point,
    Rect,
    Disc,
}

impl LightKind {
    pub(crate) const ALL: [Self; 5] = [
        Self::Directional,
        Self::Spot,
        Self::Point,
        Self::Rect,
        Self::Disc,
    ];

    pub(crate) const fn name(self) -> &'static str {
        match self {
            Self::Directional => "directional",
            Self::Spot => "spot",
            Self::Point => "point",
            Self::Rect => "rectangle",
            Self::Disc => "disc",
        }
    }

    pub(crate) const fn of_light(light: &Light) -> Self {
        match light {
            Light::Directional { .. } => Self::Directional,
            Light::Spot { .. } => Self::Spot,
            Light::Point { .. } => Self::Point,
            Light::Rect { .. } => Self::Rect,
            Light::Disc { .. } => Self::Disc,
        }
    }
}

impl EditLight {
    /// Returns a light of a scene, with a brightness for this number of lights.
    pub(crate) fn of_scene(light: Light, count: usize) -> Self {
        Self {
            light,
            color: [1.0, 0.96, 0.9],
            brightness: 0.9 / (count.max(1) as f32).sqrt(),
            is_on: true,
        }
    }

    /// Returns a new light above the centre of a scene.
    pub(crate) fn above_bounds(bounds: &Aabb) -> Self {
        let reach = reach_of(bounds);
        let position = bounds.center() + Vec3::new(0.15, 0.45, 0.2) * reach;
        let light = Light::Point {
            position,
            radius: 0.0,
        };
        Self {
            color: [1.0, 0.8, 0.55],
            ..Self::of_scene(light, 2)
        }
    }

    /// Returns the position at which the light is drawn and dragged: its centre. Directional lights
    /// have no position. Their marker is next to the point that the camera looks at, on the side of
    /// the light.
    pub(crate) fn marker(&self, looked_at: &LookedAt) -> Vec3 {
        let away = direction_of(&self.light) * looked_at.reach;
        self.light.position().unwrap_or(looked_at.point - away)
    }

    /// Moves the marker. A directional light points from the marker to the point that the camera
    /// looks at.
    pub(crate) fn move_marker(&mut self, to: Vec3, looked_at: &LookedAt) {
        self.light = self.light.moved_to(to);
        if let Light::Directional { direction, .. } = &mut self.light {
            let along = looked_at.point - to;
            if along.length() > 1e-3 * looked_at.reach {
                *direction = along.normalize();
            }
        }
    }

    /// Turns the light about its marker.
    pub(crate) fn turn(&mut self, by: Quat) {
        match &mut self.light {
            Light::Directional { direction, .. } | Light::Spot { direction, .. } => {
                *direction = (by * *direction).normalize();
            }
            Light::Point { .. } => {}
            Light::Rect { half_u, half_v, .. } => {
                *half_u = by * *half_u;
                *half_v = by * *half_v;
            }
            Light::Disc { normal, .. } => *normal = (by * *normal).normalize(),
        }
    }

    /// Reports whether turning has an effect.
    pub(crate) const fn can_turn(&self) -> bool {
        !matches!(self.light, Light::Point { .. })
    }

    /// Converts the light to another kind with the same position, direction and extent, as far as
    /// the kinds have them.
    pub(crate) fn retype(&mut self, kind: LightKind, bounds: &Aabb) {
        if LightKind::of_light(&self.light) == kind {
            return;
        }
        let position = self.marker(&LookedAt {
            point: bounds.center(),
            reach: 0.4 * reach_of(bounds),
        });
        let to_center = (bounds.center() - position).normalize_or(Vec3::NEG_Y);
        let direction = match self.light {
            Light::Directional { .. } | Light::Spot { .. } => direction_of(&self.light),
            Light::Rect { half_u, half_v, .. } => {
                let normal = half_u.cross(half_v).normalize_or(to_center);
                normal * normal.dot(to_center).signum()
            }
            Light::Disc { normal, .. } => normal.normalize() * normal.dot(to_center).signum(),
            Light::Point { .. } => to_center,
        };
        // Compute the extent, metres at the light's position.
        let away = 0.4 * reach_of(bounds);
        let radius = match self.light {
            Light::Directional {
                angular_diameter, ..
            } => away * (0.5 * angular_diameter).tan(),
            Light::Spot { radius, .. }
            | Light::Point { radius, .. }
            | Light::Disc { radius, .. } => radius,
            Light::Rect { half_u, half_v, .. } => (half_u.length() * half_v.length()).sqrt(),
        };
        let extent = if radius > 0.0 { radius } else { 0.04 * away };
        self.light = match kind {
            LightKind::Directional => Light::Directional {
                direction,
                angular_diameter: 2.0 * (radius / away).atan(),
            },
            LightKind::Spot => Light::Spot {
                position,
                direction,
                inner: 0.6,
                outer: 0.75,
                radius,
            },
            LightKind::Point => Light::Point { position, radius },
            LightKind::Rect => {
                let half_u = direction.any_orthonormal_vector() * extent;
                Light::Rect {
                    center: position,
                    half_u,
                    half_v: direction.cross(half_u).normalize() * extent,
                }
            }
            LightKind::Disc => Light::Disc {
                center: position,
                normal: direction,
                radius: extent,
            },
        };
    }

    /// Converts a directional light to a spot light with a perspective map on the same side, or
    /// such a spot light back.
    pub(crate) fn set_perspective(&mut self, has_perspective: bool, bounds: &Aabb) {
        let kind = if has_perspective {
            LightKind::Spot
        } else {
            LightKind::Directional
        };
        self.retype(kind, bounds);
        let reach = reach_of(bounds);
        if let Light::Spot {
            position,
            direction,
            inner,
            outer,
            ..
        } = &mut self.light
        {
            let away = 1.2 * reach;
            *position = bounds.center() - *direction * away;
            // Let the cone contain a ball around the scene.
            *outer = (0.5 * reach / away).asin() + 0.02;
            *inner = *outer;
        }
    }

    /// Returns the linear colour, brightness included.
    pub(crate) fn linear_color(&self) -> Vec3 {
        let decode = |c: f32| umbrage::picture::decode((255.0 * c.clamp(0.0, 1.0)).round() as u8);
        Vec3::from(self.color.map(decode)) * self.brightness
    }
}

fn direction_of(light: &Light) -> Vec3 {
    match *light {
        Light::Directional { direction, .. } | Light::Spot { direction, .. } => {
            direction.normalize_or(Vec3::NEG_Y)
        }
        _ => Vec3::NEG_Y,
    }
}

/// Returns the diagonal of the scene, metres.
fn reach_of(bounds: &Aabb) -> f32 {
    bounds.diagonal().max(1e-3)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn bounds() -> Aabb {
        Aabb {
            min: Vec3::new(-3.0, 0.0, -2.0),
            max: Vec3::new(5.0, 4.0, 6.0),
        }
    }

    /// Returns one light of each kind, with an extent and without.
    fn lights() -> Vec<Light> {
        let position = Vec3::new(1.0, 6.0, 3.0);
        let direction = Vec3::new(0.3, -1.0, 0.2).normalize();
        let mut out = Vec::new();
        for extent in [0.0, 0.2] {
            out.push(Light::Directional {
                direction,
                angular_diameter: extent,
            });
            out.push(Light::Spot {
                position,
                direction,
                inner: 0.3,
                outer: 0.5,
                radius: extent,
            });
            out.push(Light::Point {
                position,
                radius: extent,
            });
        }
        let half_u = direction.any_orthonormal_vector() * 0.2;
        out.push(Light::Rect {
            center: position,
            half_u,
            half_v: direction.cross(half_u),
        });
        out.push(Light::Disc {
            center: position,
            normal: direction,
            radius: 0.2,
        });
        out
    }

    #[test]
    fn retyped_lights_are_valid_and_stay_where_they_are() {
        for light in lights() {
            for kind in LightKind::ALL {
                let mut edited = EditLight::of_scene(light, 1);
                edited.retype(kind, &bounds());
                let words = format!("{light:?} as {kind:?}: {:?}", edited.light);
                assert_eq!(LightKind::of_light(&edited.light), kind, "{words}");
                assert!(edited.light.validate().is_ok(), "{words}");
                if let (Some(before), Some(after)) = (light.position(), edited.light.position()) {
                    assert_eq!(before, after, "{words}");
                }
                if kind == LightKind::of_light(&light) {
                    assert_eq!(edited.light, light, "{words}");
                }
            }
        }
    }

    #[test]
    fn lights_keep_their_direction_and_size_as_far_as_kinds_have_them() {
        let mut edited = EditLight::of_scene(lights()[4 + 2], 1);
        let Light::Rect { half_u, half_v, .. } = edited.light else {
            panic!("{:?}", edited.light);
        };
        let normal = half_u.cross(half_v).normalize();
        edited.retype(LightKind::Disc, &bounds());
        let Light::Disc {
            normal: of_disc,
            radius,
            ..
        } = edited.light
        else {
            panic!("{:?}", edited.light);
        };
        assert!(normal.dot(of_disc).abs() > 0.9999, "{normal} {of_disc}");
        assert!((radius - 0.2).abs() < 1e-5, "{radius}");
        edited.retype(LightKind::Directional, &bounds());
        assert!(direction_of(&edited.light).dot(normal).abs() > 0.9999);
        edited.retype(LightKind::Spot, &bounds());
        let Light::Spot {
            radius: of_spot,
            direction,
            ..
        } = edited.light
        else {
            panic!("{:?}", edited.light);
        };
        assert!(direction.dot(normal).abs() > 0.9999);
        // Convert to the sun's angle and back.
        assert!((of_spot - 0.2).abs() < 1e-3, "{of_spot}");
    }

    #[test]
    fn perspective_goes_there_and_back() {
        let sun = lights()[0];
        let mut edited = EditLight::of_scene(sun, 1);
        edited.set_perspective(true, &bounds());
        let Light::Spot {
            position,
            direction,
            outer,
            ..
        } = edited.light
        else {
            panic!("{:?}", edited.light);
        };
        assert!(direction.dot(direction_of(&sun)) > 0.9999);
        // Expect all corners of the scene in its cone.
        let (min, max) = (bounds().min, bounds().max);
        for i in 0..8 {
            let pick = |axis: usize, bit: u8| if i & bit == 0 { min[axis] } else { max[axis] };
            let corner = Vec3::new(pick(0, 1), pick(1, 2), pick(2, 4));
            let angle = (corner - position).normalize().angle_between(direction);
            assert!(angle <= outer, "{corner}: {angle} {outer}");
        }
        edited.set_perspective(false, &bounds());
        assert!(direction_of(&edited.light).dot(direction_of(&sun)) > 0.9999);
        assert_eq!(LightKind::of_light(&edited.light), LightKind::Directional);
    }
}
