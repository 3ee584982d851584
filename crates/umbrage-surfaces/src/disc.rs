//! The Sun's disc: the share of it that points see, and lit areas averaged over it.

use crate::{
    Facets, FacetsError, LitArea, Points, Stated, Suns,
    lit_area::{TILE, add_areas},
    polygons::{Contour, covered_share, union_share},
    rays::Rays,
    stated::AnswerHash,
    suns::frame_towards,
};
use glam::{DMat3, DVec2, DVec3};
use std::f64::consts::TAU;

/// Error of a share of the disc by rounding alone.
const ROUNDING: f64 = 1e-9;
/// Share of the disc below which a caster is not cut from it. Such shares are added to the bound.
const NOTHING: f64 = 1e-14;

/// A disc in the sky, evenly bright.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Disc {
    /// Angle between its centre and its edge, degrees, in 0..45.
    pub radius_degrees: f64,
    /// Number of casters up to which a share is exact. With more, the others are bounded.
    pub max_casters: usize,
}

impl Default for Disc {
    /// The Sun from the Earth: 0.53 degrees across.
    fn default() -> Self {
        Self {
            radius_degrees: 0.265,
            max_casters: 256,
        }
    }
}

impl Disc {
    /// Returns the radius of its image at the distance 1.
    fn slope(&self) -> f64 {
        self.radius_degrees.to_radians().tan()
    }

    /// Returns an error unless the radius is usable.
    pub(crate) fn check(&self) -> Result<(), FacetsError> {
        let value = self.radius_degrees;
        if value > 0.0 && value < 45.0 {
            return Ok(());
        }
        let why = format!("has a radius of {value} degrees");
        Err(FacetsError::new(
            "disc",
            why,
            "use more than 0 and less than 45",
        ))
    }
}

/// The share of the disc that each point sees.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct DiscShares {
    /// Shares, 0..=1, sun by sun, one per point.
    pub shares: Vec<f64>,
    /// Greatest errors of the shares.
    pub errors: Vec<f64>,
    /// Accuracy and hash.
    pub stated: Stated,
}

impl Facets {
    /// Returns the share of the disc around each sun that each point sees. A normal's horizon hides
    /// the part of the disc below it.
    ///
    /// Casters are projected onto the plane at the distance 1 towards the sun, where the disc is a
    /// circle. The share is that of the circle's area outside their union, which is exact. Where
    /// more than [`Disc::max_casters`] overlap the disc, the largest ones are exact and the others
    /// are bounded by the sum of their areas: the share is the middle of the bounds.
    ///
    /// # Errors
    /// Errors if the radius of the disc is out of range.
    pub fn disc_share(
        &self,
        points: &Points,
        suns: &Suns,
        disc: &Disc,
    ) -> Result<DiscShares, FacetsError> {
        disc.check()?;
        let rays = Rays::new(self, points);
        let mut out = DiscShares::default();
        let mut hash = AnswerHash::new();
        let mut worst: f64 = 0.0;
        for &sun in suns.directions() {
            let frame = frame_towards(sun);
            let mut by_row = vec![[0.0; 2]; points.count()];
            points.visit_rows(
                |(): &mut (), row| disc_seen(&rays, row, &frame, disc),
                |row, seen| by_row[row] = seen,
                |_| (),
            );
            for [share, error] in by_row {
                hash.add(share);
                hash.add(error);
                worst = worst.max(error);
                out.shares.push(share);
                out.errors.push(error);
            }
        }
        out.stated = Stated {
            margin_m: rays.margin,
            disc_degrees: Some(disc.radius_degrees),
            disc_error: Some(worst),
            hash: hash.finish(),
            ..Stated::default()
        };
        Ok(out)
    }

    /// Computes lit areas averaged over the disc around each sun, and passes them to `visit` like
    /// [`Facets::lit_area`].
    ///
    /// The average is over 19 points of equal shares. [`Stated::disc_error`] is an estimate: the
    /// greatest difference of a fraction from the average over 7 points. Each centroid is that of
    /// all lit parts, weighted by their areas.
    ///
    /// # Errors
    /// Errors if the radius of the disc is out of range.
    pub fn lit_area_of_disc(
        &self,
        suns: &Suns,
        disc: &Disc,
        mut visit: impl FnMut(usize, &[LitArea]),
    ) -> Result<Stated, FacetsError> {
        disc.check()?;
        let mut hash = AnswerHash::new();
        let mut stated = Stated {
            margin_m: self.margin_m(),
            disc_degrees: Some(disc.radius_degrees),
            ..Stated::default()
        };
        let mut worst: f64 = 0.0;
        for (i, &sun) in suns.directions().iter().enumerate() {
            let fine = self.average_over(sun, &points_of_disc(&[1, 6, 12], disc.slope()));
            let coarse = self.average_over(sun, &points_of_disc(&[1, 6], disc.slope()));
            for (fine, coarse) in fine.iter().zip(&coarse) {
                worst = worst.max((fine.fraction - coarse.fraction).abs());
            }
            add_areas(&mut hash, &fine);
            visit(i, &fine);
        }
        stated.disc_error = Some(worst);
        stated.hash = hash.finish();
        Ok(stated)
    }

    /// Returns the mean lit areas over directions, given at the distance 1 across a sun.
    fn average_over(&self, sun: DVec3, points: &[DVec2]) -> Vec<LitArea> {
        let frame = frame_towards(sun);
        let weight = 1.0 / points.len() as f64;
        let mut sums = vec![LitArea::default(); self.count()];
        for point in points {
            let direction = (frame * point.extend(1.0)).normalize();
            let part = self.lit_areas_towards(direction, TILE).areas;
            for (sum, part) in sums.iter_mut().zip(&part) {
                sum.fraction += part.fraction * weight;
                sum.area += part.area * weight;
                sum.projected += part.projected * weight;
                sum.centroid += part.centroid * (part.area * weight);
            }
        }
        for (row, sum) in sums.iter_mut().enumerate() {
            sum.fraction = sum.fraction.min(1.0);
            sum.centroid = if sum.area > 0.0 {
                sum.centroid / sum.area
            } else {
                self.centre(row)
            };
        }
        sums
    }
}

/// Returns points on rings, one for each of equal parts of a disc with this radius.
fn points_of_disc(rings: &[usize], radius: f64) -> Vec<DVec2> {
    let total: usize = rings.iter().sum();
    let mut points = Vec::with_capacity(total);
    for &count in rings {
        // The ring's middle by area. The first part is the disc's centre.
        let inner = points.len() as f64;
        let middle = if count == 1 {
            0.0
        } else {
            inner + 0.5 * count as f64
        };
        let ring_radius = radius * (middle / total as f64).sqrt();
        for i in 0..count {
            let angle = TAU * (i as f64 + 0.5) / count as f64;
            points.push(DVec2::from_angle(angle) * ring_radius);
        }
    }
    points
}

/// Returns the share of the disc that a point sees, and its greatest error.
pub(crate) fn disc_seen(rays: &Rays<'_>, row: usize, frame: &DMat3, disc: &Disc) -> [f64; 2] {
    let radius = disc.slope();
    let [p, normal] = rays.point(row);
    // Casters' shares of the disc, and their images.
    let mut casters: Vec<(f64, Contour)> = Vec::new();
    let mut negligible = 0.0;
    let mut add = |image: Contour| {
        let share = covered_share(radius, &image);
        if share > NOTHING {
            casters.push((share, image));
        } else {
            negligible += share.abs();
        }
        share > 1.0 - NOTHING
    };
    let mut is_dark = horizon(normal, frame, radius).is_some_and(&mut add);
    if !is_dark {
        rays.visit_in_cone(p, frame.z_axis, radius, |corners| {
            is_dark = image_of(corners, frame, radius).is_some_and(&mut add);
            is_dark
        });
    }
    if is_dark {
        return [0.0, ROUNDING];
    }
    if casters.is_empty() {
        return [1.0, negligible];
    }
    // The largest ones are exact, the others are bounded.
    casters.sort_by(|a, b| b.0.total_cmp(&a.0));
    let (largest, others) = casters.split_at(disc.max_casters.min(casters.len()));
    let bound = negligible + others.iter().map(|caster| caster.0).sum::<f64>();
    let images: Vec<&Contour> = largest.iter().map(|caster| &caster.1).collect();
    let most = 1.0 - union_share(radius, &images);
    let least = (most - bound).max(0.0);
    [0.5 * (least + most), 0.5 * (most - least) + ROUNDING]
}

/// Returns the part of the disc's square below a point's horizon; `None` if there is none.
fn horizon(normal: DVec3, frame: &DMat3, radius: f64) -> Option<Contour> {
    if normal == DVec3::ZERO {
        return None;
    }
    let square = [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]];
    let square = square.map(|corner| (DVec2::from(corner) * (2.0 * radius)).extend(1.0));
    let below = cut_polygon(&square, |p| -(frame * p).dot(normal));
    (below.len() > 2).then(|| below.iter().map(|p| [p.x, p.y]).collect())
}

/// Returns the image of a facet (corners relative to the point) at the distance 1 towards the sun,
/// counter-clockwise; `None` if it doesn't overlap the disc's square.
fn image_of(corners: [DVec3; 3], frame: &DMat3, radius: f64) -> Option<Contour> {
    let corners = corners.map(|corner| frame.transpose_mul_vec3(corner));
    // Cut the facet by the pyramid around the cone, in space: behind it there is nothing. Its sides
    // are twice as far as the disc, so that they don't touch it.
    let mut polygon = corners.to_vec();
    for axis in [DVec3::X, DVec3::NEG_X, DVec3::Y, DVec3::NEG_Y] {
        polygon = cut_polygon(&polygon, |p| 2.0 * radius * p.z + axis.dot(p));
    }
    polygon.retain(|p| p.z > 0.0);
    let mut image: Vec<DVec2> = polygon.iter().map(|p| DVec2::new(p.x, p.y) / p.z).collect();
    image.dedup();
    if image.len() < 3 {
        return None;
    }
    let twice_area: f64 = image
        .windows(2)
        .map(|pair| (pair[0] - image[0]).perp_dot(pair[1] - image[0]))
        .sum();
    if twice_area < 0.0 {
        image.reverse();
    }
    (twice_area != 0.0).then(|| image.iter().map(|p| p.to_array()).collect())
}

/// Returns the part of a convex polygon where a linear function is positive.
fn cut_polygon(polygon: &[DVec3], value: impl Fn(DVec3) -> f64) -> Vec<DVec3> {
    let mut out = Vec::with_capacity(polygon.len() + 1);
    let [.., last] = polygon else {
        return out;
    };
    let mut from = *last;
    for &to in polygon {
        let values = [value(from), value(to)];
        if values[0] * values[1] < 0.0 {
            out.push(from + (to - from) * (values[0] / (values[0] - values[1])));
        }
        if values[1] >= 0.0 {
            out.push(to);
        }
        from = to;
    }
    out
}
