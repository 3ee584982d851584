//! The scene: a plaza between two colonnades, with trees, crates, lamps, and things that move.

use crate::meshes::Shape;
use std::f32::consts::TAU;
use umbrage::{
    Light,
    glam::{Affine3A, Quat, Vec3},
};

/// A mesh that stands somewhere.
pub struct Object {
    pub shape: Shape,
    /// Linear.
    pub color: [f32; 3],
    /// Whether its surface shows stones.
    pub paved: bool,
    rest: Affine3A,
    motion: Option<Motion>,
}

/// How an object moves.
#[derive(Clone, Copy)]
struct Motion {
    /// Turns around an axis through this point.
    pivot: Vec3,
    axis: Vec3,
    /// Radians a second.
    speed: f32,
    /// Metres that it hops.
    hop: f32,
    /// Radians.
    phase: f32,
}

/// A light and how bright it is.
pub struct Lamp {
    pub light: Light,
    /// Linear; of lamps, at a distance of a metre.
    pub color: Vec3,
    /// Metres at which its light has faded away.
    pub range: f32,
    /// The sun's maps have this many times as many texels along each side.
    pub map_divisor: u32,
}

/// The most lights that the scene's shaders take.
pub const MAX_LAMPS: usize = 16;

const STONE: u32 = 0xd8cdb8;
const DARK_STONE: u32 = 0x9a8f80;
const WOOD: u32 = 0x94704a;
const LEAVES: u32 = 0x5f8446;
const METAL: u32 = 0x3d4148;
const ROOF: u32 = 0xb5563c;

impl Object {
    /// Returns where it is after some seconds.
    pub fn place(&self, seconds: f32) -> Affine3A {
        let Some(m) = self.motion else {
            return self.rest;
        };
        let height = m.hop * (2.5 * seconds + m.phase).sin().abs();
        let turn = Quat::from_axis_angle(m.axis, m.speed * seconds + m.phase);
        Affine3A::from_translation(m.pivot + Vec3::Y * height)
            * Affine3A::from_quat(turn)
            * Affine3A::from_translation(-m.pivot)
            * self.rest
    }
}

/// The objects in the order of their shapes, so that each shape is one instanced draw.
pub fn objects() -> Vec<Object> {
    let mut plaza = Plaza::default();
    plaza.ground();
    for side in [-1.0, 1.0] {
        plaza.colonnade(side);
    }
    plaza.pavilion();
    plaza.fountain();
    plaza.carousel();
    plaza.windmill();
    for (x, z, size) in [
        (-9.5, 8.0, 1.0),
        (-9.0, -8.5, 1.25),
        (9.4, -9.0, 0.95),
        (9.0, 7.5, 1.2),
        (-11.0, 16.5, 1.0),
        (9.8, 15.5, 1.05),
    ] {
        plaza.tree(Vec3::new(x, 0.0, z), size);
    }
    plaza.crates();
    for lamp in lamps() {
        plaza.lantern(&lamp.light);
    }
    plaza.objects.sort_by_key(|object| object.shape);
    plaza.objects
}

/// A sun, eight spots under the colonnades, and two lanterns.
pub fn lamps() -> Vec<Lamp> {
    let mut out = vec![sun(false)];
    for side in [-1.0, 1.0] {
        for i in 0..4 {
            let z = -12.0 + 8.0 * i as f32;
            out.push(Lamp {
                light: Light::Spot {
                    position: Vec3::new(17.0 * side, 4.7, z),
                    direction: Vec3::new(-0.9 * side, -1.0, 0.12 * (i as f32 - 1.5)),
                    inner: 0.5,
                    outer: 0.75,
                    radius: 0.0,
                },
                color: if i % 2 == 0 {
                    Vec3::new(95.0, 50.0, 16.0)
                } else {
                    Vec3::new(28.0, 55.0, 100.0)
                },
                range: 17.0,
                map_divisor: 2,
            });
        }
    }
    for side in [-1.0, 1.0] {
        out.push(Lamp {
            light: Light::Point {
                position: Vec3::new(5.2 * side, 2.9, 6.4 * side),
                radius: 0.0,
            },
            color: Vec3::new(34.0, 19.0, 7.0),
            range: 14.0,
            map_divisor: 2,
        });
    }
    out
}

/// The sun; with perspective, a lamp where it would stand over the plaza, as textbooks draw it.
pub fn sun(perspective: bool) -> Lamp {
    let direction = Vec3::new(-0.62, -0.52, -0.4);
    let color = Vec3::new(2.5, 1.85, 1.2);
    if !perspective {
        return Lamp {
            light: Light::Directional {
                direction,
                angular_diameter: 0.0,
            },
            color,
            range: f32::INFINITY,
            map_divisor: 1,
        };
    }
    let distance = 45.0;
    Lamp {
        light: Light::Spot {
            position: -direction.normalize() * distance,
            direction,
            inner: 0.38,
            outer: 0.42,
            radius: 0.0,
        },
        // As bright in the middle of the plaza as the sun.
        color: color * distance * distance,
        range: 200.0,
        map_divisor: 1,
    }
}

#[derive(Default)]
struct Plaza {
    objects: Vec<Object>,
}

impl Plaza {
    /// Adds an object that stands on a point, with these sizes along x, y and z.
    fn add(&mut self, shape: Shape, color: u32, at: Vec3, size: Vec3) -> &mut Object {
        let rest = Affine3A::from_scale_rotation_translation(size, Quat::IDENTITY, at);
        self.objects.push(Object {
            shape,
            color: linear(color),
            paved: false,
            rest,
            motion: None,
        });
        let last = self.objects.len() - 1;
        &mut self.objects[last]
    }

    fn ground(&mut self) {
        let size = Vec3::new(90.0, 0.5, 90.0);
        let at = Vec3::new(0.0, -0.5, 0.0);
        self.add(Shape::Box, 0xb9ad98, at, size).paved = true;
    }

    fn colonnade(&mut self, side: f32) {
        let at = |x: f32, y: f32, z: f32| Vec3::new(x * side, y, z);
        self.add(
            Shape::Box,
            DARK_STONE,
            at(16.6, 0.0, 0.0),
            Vec3::new(7.0, 0.25, 36.0),
        );
        for i in 0..9 {
            let z = -16.0 + 4.0 * i as f32;
            self.column(at(14.0, 0.25, z), 4.6, 0.42);
        }
        self.add(
            Shape::Box,
            STONE,
            at(14.0, 4.85, 0.0),
            Vec3::new(1.2, 0.6, 35.0),
        );
        self.add(
            Shape::Box,
            ROOF,
            at(16.6, 5.45, 0.0),
            Vec3::new(7.4, 0.3, 36.4),
        );
        self.add(
            Shape::Box,
            STONE,
            at(19.8, 0.25, 0.0),
            Vec3::new(0.6, 5.2, 36.0),
        );
    }

    fn column(&mut self, at: Vec3, height: f32, radius: f32) {
        let plate = Vec3::new(2.6 * radius, 0.25, 2.6 * radius);
        self.add(Shape::Box, STONE, at, plate);
        let shaft = Vec3::new(radius, height - 0.5, radius);
        self.add(Shape::Cylinder, STONE, at + Vec3::Y * 0.25, shaft);
        self.add(Shape::Box, STONE, at + Vec3::Y * (height - 0.25), plate);
    }

    fn pavilion(&mut self) {
        let z = -21.0;
        for step in 0..3 {
            let inset = 0.8 * step as f32;
            let size = Vec3::new(15.0 - inset, 0.3, 8.0 - inset);
            self.add(
                Shape::Box,
                STONE,
                Vec3::new(0.0, 0.3 * step as f32, z),
                size,
            );
        }
        for i in 0..5 {
            let x = -5.6 + 2.8 * i as f32;
            for row in [-2.4, 2.4] {
                self.column(Vec3::new(x, 0.9, z + row), 4.4, 0.34);
            }
        }
        self.add(
            Shape::Box,
            STONE,
            Vec3::new(0.0, 5.3, z),
            Vec3::new(13.0, 0.6, 6.4),
        );
        // A pyramid's corners lie on its circle, along the axes: turned by an eighth they are a roof.
        let roof = self.add(Shape::Pyramid, ROOF, Vec3::ZERO, Vec3::ONE);
        roof.rest = Affine3A::from_scale_rotation_translation(
            Vec3::new(9.8, 2.4, 5.0),
            Quat::IDENTITY,
            Vec3::new(0.0, 5.9, z),
        ) * Affine3A::from_rotation_y(TAU / 8.0);
    }

    fn fountain(&mut self) {
        let round = |radius: f32, height: f32| Vec3::new(radius, height, radius);
        self.add(Shape::Cylinder, STONE, Vec3::ZERO, round(2.6, 0.45));
        self.add(Shape::Cylinder, 0x3f7f9e, Vec3::Y * 0.45, round(2.3, 0.05));
        self.add(Shape::Cylinder, STONE, Vec3::Y * 0.4, round(0.35, 2.2));
        self.add(Shape::Cylinder, STONE, Vec3::Y * 2.4, round(1.1, 0.25));
        self.add(Shape::Ball, 0xd9a441, Vec3::Y * 3.2, Vec3::splat(0.6));
    }

    /// Adds what runs and hops around the fountain.
    fn carousel(&mut self) {
        let colors = [0xc8553d, 0x2f6690, 0xe0a030, 0x588157, 0x8e5572, 0xd9d2c5];
        for (i, &color) in colors.iter().enumerate() {
            let motion = Motion {
                pivot: Vec3::ZERO,
                axis: Vec3::Y,
                speed: 0.4,
                hop: 0.7,
                phase: i as f32 * TAU / colors.len() as f32,
            };
            let at = Vec3::new(4.6, 0.0, 0.0);
            let body = Vec3::new(0.42, 1.0, 0.42);
            self.add(Shape::Cone, color, at, body).motion = Some(motion);
            let head = at + Vec3::Y * 1.15;
            let size = Vec3::splat(0.3);
            self.add(Shape::Ball, color, head, size).motion = Some(motion);
        }
    }

    /// Adds a wheel of four arms whose shadow sweeps over the plaza.
    fn windmill(&mut self) {
        let hub = Vec3::new(7.6, 6.4, 1.0);
        let foot = Vec3::new(hub.x + 1.2, 0.0, hub.z);
        self.add(Shape::Cone, DARK_STONE, foot, Vec3::new(1.4, 8.6, 1.4));
        self.add(Shape::Ball, METAL, hub, Vec3::splat(0.4));
        for i in 0..4 {
            let motion = Motion {
                pivot: hub,
                axis: Vec3::X,
                speed: 0.7,
                hop: 0.0,
                phase: i as f32 * TAU / 4.0,
            };
            let size = Vec3::new(0.12, 3.2, 0.9);
            let at = hub + Vec3::new(-0.3, 0.5, 0.3);
            self.add(Shape::Box, 0xf0e6d2, at, size).motion = Some(motion);
            let pole = Vec3::new(0.07, 3.8, 0.07);
            self.add(Shape::Cylinder, WOOD, hub - Vec3::X * 0.3, pole)
                .motion = Some(motion);
        }
    }

    fn tree(&mut self, at: Vec3, size: f32) {
        let planter = Vec3::new(1.7, 0.5, 1.7);
        self.add(Shape::Box, DARK_STONE, at, planter);
        let trunk = Vec3::new(0.17, 2.6, 0.17) * size;
        self.add(Shape::Cylinder, 0x6b4a2e, at + Vec3::Y * 0.4, trunk);
        for (x, y, z, radius) in [
            (0.0, 3.4, 0.0, 1.15),
            (0.75, 2.9, 0.3, 0.8),
            (-0.6, 3.0, 0.5, 0.75),
            (0.1, 2.9, -0.8, 0.8),
            (-0.2, 4.2, 0.1, 0.8),
        ] {
            let middle = at + Vec3::new(x, y, z) * size;
            self.add(Shape::Ball, LEAVES, middle, Vec3::splat(radius * size));
        }
    }

    fn crates(&mut self) {
        for (x, y, z, side, turn) in [
            (-11.2, 0.0, 2.0, 1.2, 0.2),
            (-11.0, 0.0, 3.5, 1.0, 0.5),
            (-11.2, 1.2, 2.1, 0.9, 0.7),
            (-9.8, 0.0, 2.6, 0.7, 1.1),
            (11.0, 0.0, -3.0, 1.3, 0.4),
            (10.8, 1.3, -3.0, 0.8, 0.1),
            (10.0, 0.0, -1.6, 0.8, 0.9),
            (-2.4, 0.0, 10.2, 0.9, 0.6),
            (-3.4, 0.0, 9.6, 0.7, 0.1),
        ] {
            let object = self.add(Shape::Box, WOOD, Vec3::ZERO, Vec3::ONE);
            object.rest = Affine3A::from_scale_rotation_translation(
                Vec3::splat(side),
                Quat::from_rotation_y(turn),
                Vec3::new(x, y, z),
            );
        }
    }

    /// Adds what holds a lamp: above it, so that it hides none of the light.
    fn lantern(&mut self, light: &Light) {
        match *light {
            Light::Spot { position, .. } => {
                let size = Vec3::new(0.2, 0.5, 0.2);
                self.add(Shape::Cone, METAL, position + Vec3::Y * 0.05, size);
            }
            Light::Point { position, .. } => {
                let aside = Vec3::new(0.5, 0.0, 0.0);
                let pole = Vec3::new(0.06, position.y + 0.5, 0.06);
                self.add(Shape::Cylinder, METAL, position.with_y(0.0) + aside, pole);
                let arm = Vec3::new(0.6, 0.06, 0.06);
                self.add(
                    Shape::Box,
                    METAL,
                    position + 0.5 * aside + Vec3::Y * 0.44,
                    arm,
                );
                let hood = Vec3::new(0.3, 0.25, 0.3);
                self.add(Shape::Cone, METAL, position + Vec3::Y * 0.2, hood);
            }
            _ => {}
        }
    }
}

/// Returns a colour that is given as 0xrrggbb in sRGB.
fn linear(srgb: u32) -> [f32; 3] {
    [16, 8, 0].map(|shift| {
        let encoded = ((srgb >> shift) & 255) as f32 / 255.0;
        // The exact curve (IEC 61966-2-1).
        if encoded <= 0.04045 {
            encoded / 12.92
        } else {
            ((encoded + 0.055) / 1.055).powf(2.4)
        }
    })
}
