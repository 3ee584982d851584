//! Sample patterns: tap positions of a soft filter, as tables that both halves read.
//!
//! Each pattern exists for the disc and for the square, evenly distributed over the area, in
//! coordinates -1..1:
//!
//! - **Vogel** (Vogel 1979, "A better way to construct the sunflower head"): on the disc, radius
//!   sqrt((i + 1/2) / n) at i golden angles. On the square, the same lattice in x and y, which is
//!   the Fibonacci lattice.
//! - **Poisson**: no two taps are close together. Best of many candidates (Mitchell 1991,
//!   "Spectrally optimal sampling for distribution ray tracing"), which are hashes of their number.
//!   Distances wrap around on the square.
//! - **Grid**: rows of cells of equal area. Discs use the area-preserving map of Shirley and Chiu.
//!
//! The same pattern at every pixel would show as bands. So each pixel rotates it (disc) or shifts
//! it cyclically (square) by one of [`TURNS`] steps, which turns bands into fine noise. The step is
//! chosen by interleaved gradient noise (Jimenez 2014, "Next generation post processing in Call of
//! Duty: Advanced Warfare").

use glam::{DVec2, Vec2, Vec3, Vec4};
use std::{
    f64::consts::TAU,
    sync::{Arc, Mutex, PoisonError},
};
use umbrage_core::{
    Invalid, Module, Table,
    light_sample::{disc_point, hash},
    module,
};

/// The WGSL half. It reads the kernel's first table.
pub const PATTERN: Module = module!("sample_pattern");

/// Maximum number of taps in a set. With many more, the innermost taps would be nearer to the
/// centre than [`from_middle`] can represent.
pub const MAX_TAPS: u32 = 255;

/// Number of steps in a pixel's full turn.
pub const TURNS: u32 = 64;

/// Number of candidates per Poisson tap. The one farthest from all previous taps is used.
const CANDIDATES: u32 = 32;
/// Seed of the Poisson pattern's hash.
const POISSON_SEED: u32 = 0x5eed;
/// Fraction of a turn between neighbours of Vogel's spiral: 2 minus the golden ratio.
const GOLDEN: f64 = 0.381_966_011_250_105_1;

/// Least distance of a tap from the centre. It is less than the radius of the innermost of
/// [`MAX_TAPS`] even taps, sqrt(1/2 / [`MAX_TAPS`]).
const MIN_FROM_MIDDLE: f32 = 1.0 / 32.0;

/// Set of taps: x, y, least distance from the centre (see [`from_middle`]).
#[derive(Clone, Debug)]
pub(crate) struct TapSet {
    pub(crate) taps: Vec<Vec3>,
}

/// Distribution of taps.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[cfg_attr(
    feature = "presets",
    derive(serde::Serialize, serde::Deserialize),
    serde(rename_all = "snake_case")
)]
pub enum Pattern {
    /// Sunflower spiral; on squares the Fibonacci lattice.
    #[default]
    Vogel,
    /// Random, but never close together.
    Poisson,
    /// Cells in rows.
    Grid,
}

impl Pattern {
    /// All patterns.
    pub const ALL: [Self; 3] = [Self::Vogel, Self::Poisson, Self::Grid];

    /// Returns the name for tables.
    pub fn name(self) -> &'static str {
        match self {
            Self::Vogel => "vogel",
            Self::Poisson => "poisson",
            Self::Grid => "grid",
        }
    }
}

/// Area of a tap pattern.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum PatternShape {
    /// The unit disc.
    Disc,
    /// The square -1..1.
    Square,
}

/// Returns `count` taps within -1..1, evenly distributed over the shape.
pub fn spread(pattern: Pattern, shape: PatternShape, count: u32) -> Vec<Vec2> {
    match (pattern, shape) {
        (Pattern::Vogel, PatternShape::Disc) => (0..count).map(|i| sunflower(i, count)).collect(),
        (Pattern::Vogel, PatternShape::Square) => (0..count)
            .map(|i| centre_sample(fibonacci(i, count)))
            .collect(),
        (Pattern::Poisson, _) => poisson(shape, count),
        (Pattern::Grid, _) => grid(count).map(|uv| map_to_shape(shape, uv)).collect(),
    }
}

fn sunflower(i: u32, count: u32) -> Vec2 {
    let radius = ((f64::from(i) + 0.5) / f64::from(count)).sqrt();
    (DVec2::from_angle(TAU * GOLDEN * f64::from(i)) * radius).as_vec2()
}

fn fibonacci(i: u32, count: u32) -> Vec2 {
    DVec2::new(
        (f64::from(i) + 0.5) / f64::from(count),
        (f64::from(i) * GOLDEN + 0.5).fract(),
    )
    .as_vec2()
}

/// Maps the unit square to -1..1.
fn centre_sample(uv: Vec2) -> Vec2 {
    uv * 2.0 - 1.0
}

fn map_to_shape(shape: PatternShape, uv: Vec2) -> Vec2 {
    match shape {
        PatternShape::Disc => disc_point(uv),
        PatternShape::Square => centre_sample(uv),
    }
}

/// Returns cell centres of the unit square: about as many rows as columns, each row as high as its
/// fraction of the cells.
fn grid(count: u32) -> impl Iterator<Item = Vec2> {
    let rows = count.isqrt().max(1);
    (0..rows).flat_map(move |row| {
        // Indices of the row's cells among all cells.
        let first = row * count / rows;
        let end = (row + 1) * count / rows;
        let y = (first + end) as f32 * 0.5 / count as f32;
        (first..end).map(move |i| Vec2::new(((i - first) as f32 + 0.5) / (end - first) as f32, y))
    })
}

fn poisson(shape: PatternShape, count: u32) -> Vec<Vec2> {
    let mut taps: Vec<Vec2> = Vec::new();
    for tap in 0..count {
        let first = tap * CANDIDATES;
        let best = (first..first + CANDIDATES)
            .map(|number| candidate(shape, number))
            .max_by(|&a, &b| {
                let room_a = nearest_squared(shape, &taps, a);
                let room_b = nearest_squared(shape, &taps, b);
                room_a.total_cmp(&room_b)
            });
        taps.extend(best);
    }
    taps
}

/// Returns the candidate for a tap with this number among all candidates.
fn candidate(shape: PatternShape, number: u32) -> Vec2 {
    let u = unit_hash(2 * number);
    let v = unit_hash(2 * number + 1);
    map_to_shape(shape, Vec2::new(u, v))
}

/// Returns a hash of a number, 0..1 in steps of 2^-24.
fn unit_hash(k: u32) -> f32 {
    (hash(POISSON_SEED.wrapping_add(k)) >> 8) as f32 / 16_777_216.0
}

/// Returns the square of the distance from a point to the nearest tap; infinite if there are none.
fn nearest_squared(shape: PatternShape, taps: &[Vec2], p: Vec2) -> f32 {
    taps.iter()
        .map(|&tap| distance_squared(shape, p, tap))
        .fold(f32::INFINITY, f32::min)
}

fn distance_squared(shape: PatternShape, a: Vec2, b: Vec2) -> f32 {
    let d = (a - b).abs();
    if shape == PatternShape::Disc {
        d.length_squared()
    } else {
        d.min(Vec2::splat(2.0) - d).length_squared()
    }
}

/// Sets of taps and all turns, in the layout that both halves read.
#[derive(Clone, Debug)]
pub(crate) struct PatternTable {
    /// Rows (x, y, least distance from the centre, 0) of all taps, set after set, then a row (cos,
    /// sin, shift x, shift y) per turn. See [`from_middle`].
    pub(crate) table: Table,
    pub(crate) shape: PatternShape,
    pub(crate) sets: Vec<TapSet>,
    pub(crate) turns: Vec<Vec4>,
}

type PatternKey = (Pattern, PatternShape, Vec<u32>);

/// Cache of the latest tables, newest first. Equal recipes share a table, so no backend uploads it
/// twice.
static CACHE: Mutex<Vec<(PatternKey, Arc<PatternTable>)>> = Mutex::new(Vec::new());
/// Capacity of the cache.
const CACHE_SIZE: usize = 32;

impl PatternTable {
    /// Returns the table with a set of taps for each of `counts`. Their names identify the sets in
    /// errors.
    ///
    /// # Errors
    /// Errors if a set has no taps or more than [`MAX_TAPS`].
    pub(crate) fn new(
        pattern: Pattern,
        shape: PatternShape,
        counts: &[(&str, u32)],
    ) -> Result<Arc<Self>, Invalid> {
        for (what, count) in counts {
            if !(1..=MAX_TAPS).contains(count) {
                return Err(Invalid::new(
                    *what,
                    format!("are {count}"),
                    format!("use 1 to {MAX_TAPS}"),
                ));
            }
        }
        let key = (
            pattern,
            shape,
            counts.iter().map(|c| c.1).collect::<Vec<_>>(),
        );
        let mut cache = CACHE.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some((_, table)) = cache.iter().find(|(k, _)| *k == key) {
            return Ok(table.clone());
        }
        let table = Arc::new(Self::build(pattern, shape, &key.2));
        cache.truncate(CACHE_SIZE - 1);
        cache.insert(0, (key, table.clone()));
        Ok(table)
    }

    fn build(pattern: Pattern, shape: PatternShape, counts: &[u32]) -> Self {
        let mut sets: Vec<TapSet> = Vec::new();
        for &count in counts {
            let taps = spread(pattern, shape, count).into_iter();
            sets.push(TapSet {
                taps: taps
                    .map(|q| q.extend(least_from_middle(shape, q)))
                    .collect(),
            });
        }
        let turns: Vec<Vec4> = (0..TURNS).map(|k| turn(shape, k)).collect();
        let taps = sets.iter().flat_map(|set| &set.taps).map(|q| q.extend(0.0));
        let rows: Arc<[_]> = taps
            .chain(turns.iter().copied())
            .map(|row| row.to_array().map(f32::to_bits))
            .collect();
        let table = Table {
            label: "sample pattern",
            rows: rows.into(),
        };
        Self {
            table,
            shape,
            sets,
            turns,
        }
    }
}

/// Returns the third number of a tap's row: its least distance from the centre over all rotations
/// or shifts of the pattern.
fn least_from_middle(shape: PatternShape, q: Vec2) -> f32 {
    match shape {
        PatternShape::Disc => q.length().max(MIN_FROM_MIDDLE),
        PatternShape::Square => MIN_FROM_MIDDLE,
    }
}

/// Returns step `k` of the turns: rotations for discs, shifts by a point of the Fibonacci lattice
/// for squares.
fn turn(shape: PatternShape, k: u32) -> Vec4 {
    let part = f64::from(k) / f64::from(TURNS);
    if shape == PatternShape::Disc {
        return DVec2::from_angle(TAU * part)
            .as_vec2()
            .extend(0.0)
            .extend(0.0);
    }
    Vec4::new(
        1.0,
        0.0,
        (2.0 * part) as f32,
        (2.0 * (f64::from(k) * GOLDEN).fract()) as f32,
    )
}

/// Returns a pixel's step, 0 to 63: Jimenez's fract(52.9829189 fract(.06711056 x + .00583715 y)).
/// It uses 32-bit fixed point, so that the result is the same on every device.
#[inline(always)]
pub fn noise_index(x: u32, y: u32) -> u32 {
    // Constants: .06711056 and .00583715 times 2^32; 52; .9829189 times 2^16.
    let a = x
        .wrapping_mul(288_237_660)
        .wrapping_add(y.wrapping_mul(25_070_368));
    a.wrapping_mul(52)
        .wrapping_add((a >> 16).wrapping_mul(64_417))
        >> 26
}

/// Returns two half axes (x and y of the first, then of the second), rotated by (cos, sin).
#[inline(always)]
pub fn turned(axes: Vec4, turn: Vec2) -> Vec4 {
    Vec4::new(
        axes.x * turn.x + axes.z * turn.y,
        axes.y * turn.x + axes.w * turn.y,
        axes.z * turn.x - axes.x * turn.y,
        axes.w * turn.x - axes.y * turn.y,
    )
}

/// Returns a coordinate of -1..1 that was shifted by 0..2, wrapped back into -1..1.
#[inline(always)]
pub fn wrapped(x: f32) -> f32 {
    if x >= 1.0 { x - 2.0 } else { x }
}

/// Returns the position on the map, texels, of the tap `q` (-1..1) for a receiver at `from`.
///
/// The sum is evaluated from left to right. With parentheses around the offset, one driver was
/// observed to reorder the additions. (On the CPU, `pattern_taps.rs` computes this for many
/// receivers at once with [`affine`] and [`wrapped`].)
#[cfg(feature = "testing")]
pub(crate) fn place(from: Vec2, axes: Vec4, q: Vec2) -> Vec2 {
    Vec2::new(
        affine(from.x, axes.x, axes.z, q.x, q.y),
        affine(from.y, axes.y, axes.w, q.x, q.y),
    )
}

/// Returns [`place`] of a tap that is shifted and [`wrapped`].
#[cfg(feature = "testing")]
pub(crate) fn tap_place(from: Vec2, axes: Vec4, q: Vec2, shift: Vec2) -> Vec2 {
    let x = wrapped(q.x + shift.x);
    let y = wrapped(q.y + shift.y);
    place(from, axes, Vec2::new(x, y))
}

/// Returns one coordinate of a tap's position: `from + a x + b y`.
#[inline(always)]
pub(crate) fn affine(from: f32, a: f32, b: f32, x: f32, y: f32) -> f32 {
    from + a * x + b * y
}

/// Returns the distance of a tap from the pattern's centre; 1 is the edge. `least` is the third
/// number of its row. For discs, whose taps keep their distance in every rotation, it is the
/// result.
#[inline(always)]
pub fn from_middle(x: f32, y: f32, least: f32) -> f32 {
    let farther = if x.abs() > y.abs() { x.abs() } else { y.abs() };
    if farther > least { farther } else { least }
}

/// Returns the factor that moves a tap from the distance `m` from the centre to m^3.
///
/// Half of the taps are then within a third of the radius instead of within seven tenths. Blocker
/// searches use it: the nearer a blocker is to the receiver, the nearer to the centre it must be to
/// hide any light.
#[inline(always)]
pub fn closer_by(m: f32) -> f32 {
    m * m
}

/// Returns the weight of a blocker that is found at a tap of the distance `m`, `nearer` than the
/// receiver by this difference.
///
/// The weight is the fraction of the light that it hides, times a constant for all taps. A tap that
/// was moved to the distance m^3 represents an area in proportion to d(m^6) / d(m^2) = 3 m^4.
/// Beyond a blocker twice as near, the light's area appears four times as large.
#[inline(always)]
pub fn tap_weight(m: f32, nearer: f32) -> f32 {
    m * m * (m * m) / (nearer * nearer)
}

/// All twins of this module, for the tests that compare them.
#[cfg(feature = "testing")]
pub const TWINS: &[umbrage_core::Twin] = &[
    umbrage_core::twin!(PATTERN, noise_index(x: u32, y: u32) -> u32),
    umbrage_core::twin!(PATTERN, turned(axes: Vec4, turn: Vec2) -> Vec4),
    umbrage_core::twin!(PATTERN, wrapped(x: f32) -> f32),
    umbrage_core::twin!(PATTERN, place(from: Vec2, axes: Vec4, q: Vec2) -> Vec2),
    umbrage_core::twin!(PATTERN, tap_place(from: Vec2, axes: Vec4, q: Vec2, shift: Vec2) -> Vec2),
    umbrage_core::twin!(PATTERN, closer_by(m: f32) -> f32),
    umbrage_core::twin!(PATTERN, tap_weight(m: f32, nearer: f32) -> f32),
    umbrage_core::twin!(PATTERN, from_middle(x: f32, y: f32, least: f32) -> f32),
];

#[cfg(test)]
#[path = "sample_pattern_tests.rs"]
mod tests;
