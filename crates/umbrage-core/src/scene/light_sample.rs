//! Sampling of lights: the end points of shadow rays, for truth and the traced technique.
//!
//! All of it is explicit arithmetic on `f32` and `u32` in a fixed order, without the transcendental
//! functions of either language, so that the WGSL twin is bit-equal.
//!
//! A receiver's samples are points of the unit square, from a scrambled (0, 2)-sequence: every
//! power of two of them is stratified in all elementary intervals. The map from the square to the
//! light preserves areas (for suns: solid angles). The mean of the samples is the **unweighted
//! visible fraction of the light**.

use crate::{math::dot3, recipe::shader::Module, scene::light::Light, uniforms};
use glam::{DVec3, UVec4, Vec2, Vec3, Vec4};

/// The WGSL half.
pub const LIGHT_SAMPLE: Module = crate::module!("light_sample");

/// Kinds of [`LightSampler`]: the first component of `shape`.
pub mod kind {
    /// A direction: all samples are equal.
    pub const DIRECTION: u32 = 0;
    /// A cap of directions, uniform in solid angle.
    pub const CAP: u32 = 1;
    /// A point: all samples are equal.
    pub const POINT: u32 = 2;
    /// A parallelogram.
    pub const RECT: u32 = 3;
    /// A flat disc.
    pub const DISC: u32 = 4;
    /// A sphere, as the disc through its centre that faces the receiver.
    pub const BALL: u32 = 5;
}

/// Length of segments to a light, as a fraction: they end short of it by 2^-14. A light fixture's
/// own mesh, which contains the light, must not hide it, and the rounding of a hit on it is far
/// smaller. A real caster that close to the light is missed.
pub const SHORT: f32 = 1.0 - 1.0 / 16_384.0;

/// Offset of ray origins from their surface, as a fraction (2^-20, 8 units in the last place) of a
/// length. That length is the greatest one used to compute the receiver's position or to test a
/// neighbouring triangle. Both have errors of about one to four units in its last place.
pub const LIFT: f32 = 1.0 / 1_048_576.0;

uniforms! {
    /// A light, prepared for sampling.
    pub struct LightSampler {
        /// The [`kind`]; the other components are unused. It is the first field: see
        /// `STEADY_FIRST_WORD` in umbrage-wgpu's drivers.rs.
        pub shape: UVec4,
        /// World position of the light's centre; for directions, the unit vector towards the light.
        /// Fourth component: unused.
        pub center: Vec4,
        /// Vector from the centre to the rim, metres; for caps, a unit vector perpendicular to the
        /// axis. Fourth component: for caps 1 - cos of the half angle, for spheres the radius in
        /// metres.
        pub half_u: Vec4,
        /// The second half axis, like `half_u`. Fourth component: unused.
        pub half_v: Vec4,
    }
}

impl LightSampler {
    /// Returns the sampler of a light.
    pub fn new(light: &Light) -> Self {
        match *light {
            Light::Directional {
                direction,
                angular_diameter,
            } => Self::directional(direction, angular_diameter),
            Light::Spot {
                position,
                direction,
                radius,
                ..
            } if radius > 0.0 => Self::disc(position, direction, radius),
            Light::Point { position, radius } if radius > 0.0 => {
                let half_u = Vec3::ZERO.extend(radius);
                Self::of_kind(kind::BALL, position, half_u, Vec3::ZERO)
            }
            Light::Spot { position, .. } | Light::Point { position, .. } => {
                Self::of_kind(kind::POINT, position, Vec4::ZERO, Vec3::ZERO)
            }
            Light::Rect {
                center,
                half_u,
                half_v,
            } => Self::of_kind(kind::RECT, center, half_u.extend(0.0), half_v),
            Light::Disc {
                center,
                normal,
                radius,
            } => Self::disc(center, normal, radius),
        }
    }

    fn of_kind(kind: u32, center: Vec3, half_u: Vec4, half_v: Vec3) -> Self {
        Self {
            shape: UVec4::new(kind, 0, 0, 0),
            center: center.extend(0.0),
            half_u,
            half_v: half_v.extend(0.0),
        }
    }

    fn directional(direction: Vec3, angular_diameter: f32) -> Self {
        let to_light = -direction.as_dvec3().normalize_or(DVec3::NEG_Y);
        let (u, v) = to_light.any_orthonormal_pair();
        // Compute 1 - cos(a) = 2 sin(a / 2)^2, without cancellation; the half angle a is half the
        // diameter.
        let cap = 2.0 * (0.25 * f64::from(angular_diameter)).sin().powi(2);
        let kind = if angular_diameter > 0.0 {
            kind::CAP
        } else {
            kind::DIRECTION
        };
        let half_u = u.as_vec3().extend(cap as f32);
        Self::of_kind(kind, to_light.as_vec3(), half_u, v.as_vec3())
    }

    fn disc(center: Vec3, normal: Vec3, radius: f32) -> Self {
        let normal = normal.as_dvec3().normalize_or(DVec3::Y);
        let (u, v) = normal.any_orthonormal_pair();
        let radius = f64::from(radius);
        let half_u = (u * radius).as_vec3().extend(0.0);
        Self::of_kind(kind::DISC, center, half_u, (v * radius).as_vec3())
    }

    /// Returns whether all samples are equal, so that one is enough.
    pub fn is_ideal(&self) -> bool {
        self.shape.x == kind::DIRECTION || self.shape.x == kind::POINT
    }
}

/// Returns the vector from `p` to the light's point at `uv` of the unit square, shortened by
/// [`SHORT`]; for directions its length is `far` metres.
#[inline(always)]
pub fn segment(s: &LightSampler, p: Vec3, uv: Vec2, far: f32) -> Vec3 {
    let center = Vec3::new(s.center.x, s.center.y, s.center.z);
    let u = Vec3::new(s.half_u.x, s.half_u.y, s.half_u.z);
    let v = Vec3::new(s.half_v.x, s.half_v.y, s.half_v.z);
    let kind = s.shape.x;
    if kind == kind::DIRECTION {
        return center * far;
    }
    if kind == kind::CAP {
        return cap_direction(center, u, v, s.half_u.w, disc_point(uv)) * far;
    }
    let to_center = center - p;
    if kind == kind::POINT {
        return to_center * SHORT;
    }
    if kind == kind::RECT {
        return (to_center + u * (2.0 * uv.x - 1.0) + v * (2.0 * uv.y - 1.0)) * SHORT;
    }
    let q = disc_point(uv);
    if kind == kind::DISC {
        return (to_center + u * q.x + v * q.y) * SHORT;
    }
    let n = to_center / dot3(to_center, to_center).sqrt();
    let q = q * s.half_u.w;
    (to_center + tangent(n) * q.x + bitangent(n) * q.y) * SHORT
}

/// Returns the unit vector, in the cap around the unit vector `axis`, for the point `q` of the unit
/// disc. Areas become solid angles (Archimedes' hat-box theorem: height on the sphere grows with
/// the square of the radius). `u` and `v` are unit vectors perpendicular to the axis; `cap` is 1 -
/// cos of the cap's half angle.
#[inline(always)]
pub fn cap_direction(axis: Vec3, u: Vec3, v: Vec3, cap: f32, q: Vec2) -> Vec3 {
    let h = (q.x * q.x + q.y * q.y) * cap;
    let side = (cap * (2.0 - h)).sqrt();
    axis * (1.0 - h) + u * (q.x * side) + v * (q.y * side)
}

/// Maps the unit square to the unit disc, preserving areas: Shirley, Chiu 1997, "A Low Distortion
/// Map Between Disk and Square".
#[inline(always)]
pub fn disc_point(uv: Vec2) -> Vec2 {
    const QUARTER_PI: f32 = std::f32::consts::FRAC_PI_4;
    let a = 2.0 * uv.x - 1.0;
    let b = 2.0 * uv.y - 1.0;
    if a == 0.0 && b == 0.0 {
        return Vec2::ZERO;
    }
    if a.abs() > b.abs() {
        let angle = QUARTER_PI * (b / a);
        return Vec2::new(a * small_cos(angle), a * small_sin(angle));
    }
    let angle = QUARTER_PI * (a / b);
    Vec2::new(b * small_sin(angle), b * small_cos(angle))
}

/// Returns the sine of an angle within -pi/4..pi/4, to 1e-7, by its Taylor series.
#[inline(always)]
pub fn small_sin(x: f32) -> f32 {
    let q = x * x;
    x * (1.0 + q * (-1.666_666_7e-1 + q * (8.333_333e-3 + q * (-1.984_127e-4 + q * 2.755_732e-6))))
}

/// Returns the cosine of an angle within -pi/4..pi/4, to 1e-7, by its Taylor series.
#[inline(always)]
pub fn small_cos(x: f32) -> f32 {
    let q = x * x;
    1.0 + q * (-0.5 + q * (4.166_666_8e-2 + q * (-1.388_888_9e-3 + q * 2.480_158_7e-5)))
}

/// Returns a unit vector perpendicular to the unit vector `n`: Duff et al. 2017, "Building an
/// Orthonormal Basis, Revisited".
#[inline(always)]
pub fn tangent(n: Vec3) -> Vec3 {
    let sign = if n.z >= 0.0 { 1.0 } else { -1.0 };
    let a = -1.0 / (sign + n.z);
    Vec3::new(
        1.0 + sign * n.x * n.x * a,
        sign * (n.x * n.y * a),
        -sign * n.x,
    )
}

/// Returns a unit vector perpendicular to the unit vector `n` and its [`tangent`].
#[inline(always)]
pub fn bitangent(n: Vec3) -> Vec3 {
    let sign = if n.z >= 0.0 { 1.0 } else { -1.0 };
    let a = -1.0 / (sign + n.z);
    Vec3::new(n.x * n.y * a, sign + n.y * n.y * a, -n.y)
}

/// Returns the offset of a ray's origin from its surface, metres. `p` is the receiver, `reach` the
/// greatest other length whose rounding moves it off its surface (distance to the eye, lengths of
/// the receiver's triangle).
#[inline(always)]
pub fn origin_offset(p: Vec3, reach: f32) -> f32 {
    p.x.abs().max(p.y.abs()).max(p.z.abs()).max(reach) * LIFT
}

/// Returns the origin of the rays of a receiver at `p` with the unit normal `n`, offset from its
/// surface. `eye` is the camera's position. `plane_reach` is the greatest length of a receiving
/// triangle whose rounding moves receivers off its plane, metres: `Geometry::receiver_reach`.
#[inline(always)]
pub fn ray_origin(p: Vec3, n: Vec3, eye: Vec3, plane_reach: f32) -> Vec3 {
    let to_eye = (eye - p).abs();
    let reach = to_eye.x.max(to_eye.y).max(to_eye.z).max(plane_reach);
    p + n * origin_offset(p, reach)
}

/// Returns the scramble of a pixel.
#[inline(always)]
pub fn seed(x: u32, y: u32) -> u32 {
    hash(x.wrapping_add(hash(y.wrapping_add(0x9e37_79b9))))
}

/// Returns point `i` of the unit square's sequence with this scramble: van der Corput's sequence
/// and Sobol's second one, each with a nested uniform (Owen) scramble.
#[inline(always)]
pub fn unit_square(i: u32, seed: u32) -> Vec2 {
    scramble_bits(sobol_bits(i), seed)
}

/// Returns point `i` of the sequence before scrambling, as binary fractions with reversed bits
/// (lowest bit = 1/2).
#[inline(always)]
pub fn sobol_bits(i: u32) -> [u32; 2] {
    [i, sobol_second(i).reverse_bits()]
}

/// Scrambles a pair of [`sobol_bits`] into 0..1 (24 bits each, never 1).
#[inline(always)]
pub fn scramble_bits(bits: [u32; 2], seed: u32) -> Vec2 {
    let x = owen(bits[0], seed).reverse_bits();
    let y = owen(bits[1], hash(seed ^ 0x68bc_21eb)).reverse_bits();
    Vec2::new((x >> 8) as f32, (y >> 8) as f32) * (1.0 / 16_777_216.0)
}

/// Returns the second dimension of Sobol's sequence, as a binary fraction.
#[inline(always)]
pub fn sobol_second(i: u32) -> u32 {
    let mut rest = i;
    let mut direction = 1_u32 << 31;
    let mut bits = 0_u32;
    while rest != 0 {
        if rest & 1 == 1 {
            bits ^= direction;
        }
        direction ^= direction >> 1;
        rest >>= 1;
    }
    bits
}

/// Applies nested uniform scrambling to bit-reversed fractions, each bit by a hash of those below
/// it: Laine, Karras 2011, "Stratified Sampling for Stochastic Transparency"; constants from
/// Vegdahl 2021, "Owen Scrambling Hash Functions".
#[inline(always)]
pub fn owen(reversed: u32, seed: u32) -> u32 {
    let mut x = reversed;
    x ^= x.wrapping_mul(0x3d20_adea);
    x = x.wrapping_add(seed);
    x = x.wrapping_mul((seed >> 16) | 1);
    x ^= x.wrapping_mul(0x0552_6c56);
    x ^= x.wrapping_mul(0x53a2_2864);
    x
}

/// Mixes 32 bits: Wellons 2018, "Prospecting for Hash Functions", `lowbias32`.
#[inline(always)]
pub fn hash(x: u32) -> u32 {
    let mut x = x;
    x ^= x >> 16;
    x = x.wrapping_mul(0x7feb_352d);
    x ^= x >> 15;
    x = x.wrapping_mul(0x846c_a68b);
    x ^= x >> 16;
    x
}

/// The twins, for the lockstep tests.
#[cfg(feature = "testing")]
pub const TWINS: &[crate::recipe::twin::Twin] = &[
    crate::twin!(LIGHT_SAMPLE, small_sin(x: f32) -> f32, needs [crate::math::MATH]),
    crate::twin!(LIGHT_SAMPLE, small_cos(x: f32) -> f32, needs [crate::math::MATH]),
    crate::twin!(LIGHT_SAMPLE, disc_point(uv: Vec2) -> Vec2, needs [crate::math::MATH]),
    crate::twin!(LIGHT_SAMPLE, tangent(n: Vec3) -> Vec3, needs [crate::math::MATH]),
    crate::twin!(LIGHT_SAMPLE, bitangent(n: Vec3) -> Vec3, needs [crate::math::MATH]),
    crate::twin!(LIGHT_SAMPLE, cap_direction(axis: Vec3, u: Vec3, v: Vec3, cap: f32, q: Vec2) -> Vec3, needs [crate::math::MATH]),
    crate::twin!(LIGHT_SAMPLE, origin_offset(p: Vec3, reach: f32) -> f32, needs [crate::math::MATH]),
    crate::twin!(LIGHT_SAMPLE, ray_origin(p: Vec3, n: Vec3, eye: Vec3, plane_reach: f32) -> Vec3, needs [crate::math::MATH]),
    crate::twin!(LIGHT_SAMPLE, hash(x: u32) -> u32, needs [crate::math::MATH]),
    crate::twin!(LIGHT_SAMPLE, seed(x: u32, y: u32) -> u32, needs [crate::math::MATH]),
    crate::twin!(LIGHT_SAMPLE, owen(reversed: u32, seed: u32) -> u32, needs [crate::math::MATH]),
    crate::twin!(LIGHT_SAMPLE, sobol_second(i: u32) -> u32, needs [crate::math::MATH]),
    crate::twin!(LIGHT_SAMPLE, unit_square(i: u32, seed: u32) -> Vec2, needs [crate::math::MATH]),
];

#[cfg(test)]
mod tests {
    use super::*;

    /// Every elementary interval of a (0, 2)-sequence's first 2^m points contains exactly one
    /// point, scrambled or not.
    #[test]
    fn points_are_stratified_every_way() {
        for seed in [0, 1, 0xdead_beef] {
            for split in 0..=8 {
                let columns = 1_u32 << split;
                let rows = 1_u32 << (8 - split);
                let mut counts = vec![0; 256];
                for i in 0..256 {
                    let p = unit_square(i, seed);
                    let cx = (p.x * columns as f32) as u32;
                    let cy = (p.y * rows as f32) as u32;
                    counts[(cy * columns + cx) as usize] += 1;
                }
                assert!(
                    counts.iter().all(|&n| n == 1),
                    "seed {seed}, {columns} x {rows}: {counts:?}"
                );
            }
        }
    }

    #[test]
    fn polynomials_match_the_real_functions() {
        for i in -1000..=1000 {
            let x = i as f32 / 1000.0 * std::f32::consts::FRAC_PI_4;
            // Two roundings near 1.
            assert!((small_sin(x) - x.sin()).abs() <= 1.5e-7, "sin {x}");
            assert!((small_cos(x) - x.cos()).abs() <= 1.5e-7, "cos {x}");
        }
    }

    /// A quarter of the disc's area is within half its radius, and half of it is left of the
    /// centre.
    #[test]
    fn the_disc_keeps_areas() {
        let points: Vec<Vec2> = (0..4096).map(|i| disc_point(unit_square(i, 7))).collect();
        let share = |f: fn(&&Vec2) -> bool| points.iter().filter(f).count() as f32 / 4096.0;
        assert!((share(|p| p.length() < 0.5) - 0.25).abs() < 0.002);
        assert!((share(|p| p.x < 0.0) - 0.5).abs() < 0.002);
        assert!(points.iter().all(|p| p.length() <= 1.000_001));
    }

    #[test]
    fn caps_are_unit_vectors_within_their_angle() {
        let light = Light::Directional {
            direction: Vec3::new(1.0, -2.0, 0.5),
            angular_diameter: 0.4,
        };
        let s = LightSampler::new(&light);
        let axis = s.center.truncate();
        let angles: Vec<f32> = (0..1024)
            .map(|i| {
                let d = segment(&s, Vec3::ZERO, unit_square(i, 3), 1.0);
                assert!((d.length() - 1.0).abs() < 1e-6);
                d.cross(axis).length().asin()
            })
            .collect();
        let widest = angles.iter().copied().fold(0.0, f32::max);
        assert!(widest <= 0.2 + 1e-5 && widest > 0.19, "{widest}");
        // Half the solid angle is within acos(1 - (1 - cos 0.2) / 2) of the axis.
        let median = (1.0 - (1.0 - 0.2_f32.cos()) / 2.0).acos();
        let within = angles.iter().filter(|&&a| a < median).count();
        assert!((within as i32 - 512).abs() <= 4, "{within}");
    }

    #[test]
    fn balls_face_the_receiver() {
        let light = Light::Point {
            position: Vec3::new(1.0, 4.0, -2.0),
            radius: 0.5,
        };
        let s = LightSampler::new(&light);
        let p = Vec3::new(-3.0, 0.0, 1.0);
        let to_center = Vec3::new(4.0, 4.0, -3.0);
        for i in 0..256 {
            let d = segment(&s, p, unit_square(i, 5), 1.0) / SHORT;
            assert!((d - to_center).dot(to_center).abs() < 1e-4);
            assert!((d - to_center).length() <= 0.500_01);
        }
    }
}
