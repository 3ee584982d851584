//! Points of a light at which its visibility is tested: lattices in rows. Each group of a few
//! adjacent pixels has another lattice.
//!
//! The points of a row are evenly spaced on a line. So a linear function hides all points of a row
//! up to some point or from some point on, and a division finds it for the whole row.
//!
//! For a disc: a square lattice, rotated by its own angle and shifted. For a parallelogram: rows
//! that rise by one row's height from end to end. Each begins a golden section of a step further,
//! so that no two points have the same coordinates. Lattices are also mirrored, and rows and
//! columns exchanged. For straight edges at random positions, the error of both is about
//! [`ERROR_OF_ONE`] times the number of points to the power of -3/4, like scrambled (0, 2)-nets.

use std::sync::Arc;
use umbrage_core::{
    Module,
    glam::{DVec2, Vec2},
    module,
};

/// The WGSL half.
pub(super) const LATTICE: Module = module!("soft_lattice", "lattice.wgsl");

/// Maximum number of rows, and of points of a row: a bit each, and one for the position after the
/// last.
pub(super) const MAX_ROWS: usize = 31;

/// Number of lattices; a group of pixels selects one by its noise.
pub(super) const LATTICES: u32 = 64;

/// Number of table rows before those of a lattice's own rows.
const HEAD: usize = 2;

/// Root mean square error at straight edges for one point. With more points it is multiplied by
/// their number to the power of minus [`ERROR_POWER`]. Simulated over 3,000 random edges each for 8
/// and 16 rows: .33 to .35 over discs, .35 to .40 over squares (.11 to .14 for edges along their
/// sides).
pub(super) const ERROR_OF_ONE: f32 = 0.35;

/// Power of the number of points with which errors at straight edges decrease.
pub(super) const ERROR_POWER: f32 = 0.75;

/// Fraction of a circle, or a step, whose multiples are evenly distributed: one over the golden
/// ratio.
const GOLDEN: f64 = 0.618_033_988_749_894_9;

/// One over the root of x^3 = x + 1, and its square: the two-dimensional equivalent (Roberts 2018,
/// "The Unreasonable Effectiveness of Quasirandom Sequences").
const PLASTIC: DVec2 = DVec2::new(0.754_877_666_246_692_8, 0.569_840_290_998_053_2);

/// Area of the points.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Domain {
    /// The unit disc.
    Disc,
    /// Square from -1 to 1 in both coordinates.
    Square,
}

/// One lattice.
#[derive(Clone, Copy, Debug)]
pub(super) struct Lattice {
    /// First points of the rows.
    pub(super) u: [f32; MAX_ROWS],
    pub(super) v: [f32; MAX_ROWS],
    /// Bits of the points of a row that are in the domain, the first in the lowest bit.
    pub(super) bits: [u32; MAX_ROWS],
    /// Vector from one point of a row to the next.
    pub(super) step: Vec2,
    /// Vector from row to row, without the shift of rows.
    pub(super) rise: Vec2,
    /// First point of the first row, without the shift.
    pub(super) origin: Vec2,
    /// Number of points.
    pub(super) points: u32,
}

impl Lattice {
    /// Returns a row's first point.
    #[inline(always)]
    pub(super) fn first_of(&self, row: usize) -> Vec2 {
        Vec2::new(self.u[row], self.v[row])
    }
}

/// All lattices with the same number of rows.
#[derive(Clone, Debug)]
pub(super) struct Lattices {
    pub(super) rows: u32,
    /// Greatest shift of rows, in points.
    pub(super) shift: f32,
    all: Arc<[Lattice]>,
}

impl Lattices {
    /// Creates the lattices of `rows` rows, 1 to [`MAX_ROWS`].
    pub(super) fn new(domain: Domain, rows: u32) -> Self {
        let make = |number| match domain {
            Domain::Disc => over_disc(rows, number),
            Domain::Square => over_square(rows, number),
        };
        let shift = match domain {
            Domain::Disc => 0.0,
            Domain::Square => 1.0,
        };
        Self {
            rows,
            shift,
            all: (0..LATTICES).map(make).collect(),
        }
    }

    /// Returns the lattice of a pixel with this noise.
    #[inline(always)]
    pub(super) fn of_noise(&self, noise: u32) -> &Lattice {
        &self.all[(noise % LATTICES) as usize]
    }

    /// Returns the greatest fraction of the points whose cells one straight edge can cross.
    pub(super) fn bound(&self) -> f32 {
        let crossed = 2 * self.rows - 1;
        let fewest = self.all.iter().map(|lattice| lattice.points).min();
        let points = fewest.unwrap_or(1).max(1);
        (crossed as f32 / points as f32).min(1.0)
    }

    /// Returns the rows of a table. For each lattice, they hold its step and rise, its origin and
    /// number of points, then each row's first point and bits.
    pub(super) fn table(&self) -> Vec<[u32; 4]> {
        let mut out = Vec::with_capacity(self.all.len() * (HEAD + self.rows as usize));
        for lattice in self.all.iter() {
            let pair = |v: Vec2| v.to_array().map(f32::to_bits);
            let [step_u, step_v] = pair(lattice.step);
            let [rise_u, rise_v] = pair(lattice.rise);
            out.push([step_u, step_v, rise_u, rise_v]);
            let [u, v] = pair(lattice.origin);
            out.push([u, v, lattice.points, 0]);
            for row in 0..self.rows as usize {
                let [u, v] = [lattice.u[row], lattice.v[row]].map(f32::to_bits);
                out.push([u, v, lattice.bits[row], 0]);
            }
        }
        out
    }
}

/// Returns the number of rows whose error at straight edges is at most `error`.
pub(super) fn rows_for(error: f32, domain: Domain) -> u32 {
    let points = (ERROR_OF_ONE / error).powf(1.0 / ERROR_POWER);
    let rows = match domain {
        // Convert to the number of points in the square around the disc.
        Domain::Disc => (points / std::f32::consts::FRAC_PI_4).sqrt(),
        Domain::Square => points.sqrt(),
    };
    (rows.ceil() as u32).clamp(1, MAX_ROWS as u32)
}

/// Returns a lattice of the points for which `holds` is true. `at` returns the point for a row and
/// a position, both possibly fractional. Row `row` is shifted by `shift(row)` points.
fn lattice(
    rows: u32,
    at: impl Fn(f64, f64) -> DVec2,
    shift: impl Fn(u32) -> DVec2,
    holds: impl Fn(DVec2) -> bool,
) -> Lattice {
    let origin = at(0.0, 0.0);
    let step = at(0.0, 1.0) - origin;
    let mut out = Lattice {
        u: [0.0; MAX_ROWS],
        v: [0.0; MAX_ROWS],
        bits: [0; MAX_ROWS],
        step: step.as_vec2(),
        rise: (at(1.0, 0.0) - origin).as_vec2(),
        origin: origin.as_vec2(),
        points: 0,
    };
    for row in 0..rows {
        let first = at(f64::from(row), 0.0) + shift(row);
        let i = row as usize;
        out.u[i] = first.x as f32;
        out.v[i] = first.y as f32;
        for place in 0..rows {
            let is_held = holds(first + step * f64::from(place));
            out.bits[i] |= u32::from(is_held) << place;
        }
        out.points += out.bits[i].count_ones();
    }
    out
}

fn over_disc(rows: u32, number: u32) -> Lattice {
    let spacing = 2.0 / f64::from(rows);
    let shift = (PLASTIC * f64::from(number) + 0.5).fract() - 0.5;
    let angle = std::f64::consts::FRAC_PI_2 * (GOLDEN * f64::from(number)).fract();
    let axis = DVec2::from_angle(angle);
    let at = |row: f64, place: f64| {
        let cell = DVec2::new(place, row) + 0.5;
        axis.rotate((cell + shift) * spacing - 1.0)
    };
    let out = lattice(
        rows,
        at,
        |_| DVec2::ZERO,
        |p| p.length_squared() < DISC_RADIUS_SQUARED,
    );
    if out.points > 0 {
        return out;
    }
    // If all points of one or two rows are outside, use the centre.
    lattice(
        1,
        |row, place| DVec2::new(place, row),
        |_| DVec2::ZERO,
        |_| true,
    )
}

/// Squared radius slightly smaller than the disc's, so that rounding moves no point beyond its
/// edge.
const DISC_RADIUS_SQUARED: f64 = 0.999_999;

fn over_square(rows: u32, number: u32) -> Lattice {
    let count = f64::from(rows);
    let spacing = 2.0 / count;
    let shift = (PLASTIC * f64::from(number) + 0.5).fract();
    let turned = |p: DVec2| {
        let mut p = if number & 1 == 0 {
            p
        } else {
            DVec2::new(p.y, p.x)
        };
        if number & 2 != 0 {
            p.x = -p.x;
        }
        if number & 4 != 0 {
            p.y = -p.y;
        }
        p
    };
    let at = |row: f64, place: f64| {
        let across = row + (place + shift.y) / count;
        turned(DVec2::new(place, across) * spacing - 1.0)
    };
    let shift_of_row = |row: u32| {
        let points = (f64::from(row) * GOLDEN + shift.x).fract();
        turned(DVec2::new(points * spacing, 0.0))
    };
    lattice(rows, at, shift_of_row, |_| true)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Returns the coordinates of all points.
    fn points(lattices: &Lattices, number: u32) -> Vec<Vec2> {
        let lattice = lattices.of_noise(number);
        let mut out = Vec::new();
        for row in 0..lattices.rows as usize {
            let first = Vec2::new(lattice.u[row], lattice.v[row]);
            for place in 0..lattices.rows {
                if lattice.bits[row] >> place & 1 == 1 {
                    out.push(first + lattice.step * place as f32);
                }
            }
        }
        assert_eq!(out.len(), lattice.points as usize);
        out
    }

    /// Root mean square errors over all lattices, for edges in all directions, meet the requested
    /// error and the bound.
    #[test]
    fn edges_err_as_promised() {
        for domain in [Domain::Disc, Domain::Square] {
            for error in [0.03, 0.01, 0.004] {
                let lattices = Lattices::new(domain, rows_for(error, domain));
                let mut squares = 0.0;
                let mut edges = 0.0;
                for number in 0..LATTICES {
                    let points = points(&lattices, number);
                    for turn in 0..23 {
                        let normal = Vec2::from_angle(turn as f32 * 0.713);
                        for place in -9..10 {
                            let edge = place as f32 * 0.0987;
                            let beyond = points.iter().filter(|p| p.dot(normal) > edge);
                            let share = beyond.count() as f32 / points.len() as f32;
                            squares += (share - share_beyond(domain, normal, edge)).powi(2);
                            edges += 1.0;
                        }
                    }
                }
                let found = (squares / edges).sqrt();
                assert!(
                    (0.5 * error..1.2 * error).contains(&found),
                    "{domain:?}: {found} for {error}"
                );
            }
        }
    }

    /// Returns the fraction of the domain beyond a line, from many thin strips along it.
    fn share_beyond(domain: Domain, normal: Vec2, edge: f32) -> f32 {
        const STRIPS: i32 = 4000;
        let mut inside = 0.0;
        let mut beyond = 0.0;
        for strip in 0..STRIPS {
            let y = (strip as f32 + 0.5) * (2.0 / STRIPS as f32) - 1.0;
            let half = match domain {
                Domain::Disc => (1.0 - y * y).sqrt(),
                Domain::Square => 1.0,
            };
            // The line's part is where x n.x + y n.y > edge, for x from -half to half.
            let [from, to] = if normal.x > 0.0 {
                [(edge - y * normal.y) / normal.x, half]
            } else {
                [-half, (edge - y * normal.y) / normal.x]
            };
            inside += 2.0 * half;
            beyond += (to.min(half) - from.max(-half)).max(0.0);
        }
        beyond / inside
    }

    #[test]
    fn points_lie_in_their_domain_and_every_count_has_some() {
        for rows in 1..=MAX_ROWS as u32 {
            for domain in [Domain::Disc, Domain::Square] {
                let lattices = Lattices::new(domain, rows);
                for number in 0..LATTICES {
                    let points = points(&lattices, number);
                    assert!(!points.is_empty());
                    for p in points {
                        match domain {
                            Domain::Disc => assert!(p.length() < 1.000_001),
                            Domain::Square => assert!(p.abs().max_element() < 1.000_001),
                        }
                    }
                }
            }
        }
    }

    #[test]
    fn finer_errors_take_more_rows() {
        for domain in [Domain::Disc, Domain::Square] {
            let rows = [0.2, 0.05, 0.01, 0.005, 0.001].map(|error| rows_for(error, domain));
            assert!(rows.is_sorted() && rows[0] < rows[3], "{rows:?}");
            assert_eq!(rows[4], MAX_ROWS as u32);
        }
    }
}
