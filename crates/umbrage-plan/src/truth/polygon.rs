//! Convex polygons in the plane, in 64 bits: clipping, subtraction and areas.

use glam::DVec2;

/// Corners of a convex polygon, counter-clockwise. Fewer than three corners are the empty set.
pub(super) type FlatPolygon = Vec<DVec2>;

/// Returns the area of a polygon, positive if its corners are counter-clockwise.
pub(super) fn area(p: &[DVec2]) -> f64 {
    let Some(&first) = p.first() else { return 0.0 };
    // Measure from one corner, to keep precision far from the origin.
    p.windows(2)
        .map(|w| (w[0] - first).perp_dot(w[1] - first))
        .sum::<f64>()
        / 2.0
}

/// Returns the corners in counter-clockwise order.
pub(super) fn counter_clockwise(mut p: FlatPolygon) -> FlatPolygon {
    if area(&p) < 0.0 {
        p.reverse();
    }
    p
}

/// Returns the part of a polygon to the left of the line from `a` to `b`.
pub(super) fn left_of(p: &[DVec2], a: DVec2, b: DVec2) -> FlatPolygon {
    cut(p, |q| (b - a).perp_dot(q - a))
}

/// Returns the part of a polygon, with corners of any type, where a linear function is at least 0
/// (Sutherland, Hodgman 1974, "Reentrant Polygon Clipping").
pub(super) fn cut<
    P: Copy + std::ops::Sub<Output = P> + std::ops::Add<Output = P> + std::ops::Mul<f64, Output = P>,
>(
    p: &[P],
    side: impl Fn(P) -> f64,
) -> Vec<P> {
    let mut out = Vec::with_capacity(p.len() + 1);
    let Some(&last) = p.last() else { return out };
    let mut a = last;
    let mut a_side = side(last);
    for &b in p {
        let b_side = side(b);
        if (a_side < 0.0) != (b_side < 0.0) {
            // The edge crosses the line here.
            out.push(a + (b - a) * (a_side / (a_side - b_side)));
        }
        if b_side >= 0.0 {
            out.push(b);
        }
        a = b;
        a_side = b_side;
    }
    out
}

/// Returns whether a point is in a polygon, or on its edge.
pub(super) fn contains(p: &[DVec2], q: DVec2) -> bool {
    edges(p).all(|[a, b]| (b - a).perp_dot(q - a) >= 0.0)
}

/// Returns some points in a polygon: the mean of its corners, and one near each corner.
pub(super) fn spread(p: &[DVec2]) -> Vec<DVec2> {
    let middle = p.iter().sum::<DVec2>() / p.len().max(1) as f64;
    std::iter::once(middle)
        .chain(p.iter().map(|&corner| middle.lerp(corner, 0.95)))
        .collect()
}

/// Returns the intersection of two polygons. A `q` without corners clips nothing.
pub(super) fn common(p: &[DVec2], q: &[DVec2]) -> FlatPolygon {
    let mut part = p.to_vec();
    for [a, b] in edges(q) {
        let along = b - a;
        // Most edges keep all or nothing: test this without a copy.
        let inside = part.iter().filter(|&&c| along.perp_dot(c - a) >= 0.0);
        let inside = inside.count();
        if inside == 0 {
            return FlatPolygon::new();
        }
        if inside < part.len() {
            part = left_of(&part, a, b);
        }
    }
    part
}

/// Returns `pieces` without `q`. Parts with an area up to `dust` are dropped.
pub(super) fn subtract_polygon(
    pieces: Vec<FlatPolygon>,
    q: &[DVec2],
    dust: f64,
) -> Vec<FlatPolygon> {
    if area(q) <= dust {
        return pieces;
    }
    let mut out = Vec::with_capacity(pieces.len());
    for piece in pieces {
        if area(&common(&piece, q)) <= dust {
            out.push(piece);
            continue;
        }
        let mut inside = piece;
        for [a, b] in edges(q) {
            let outside = left_of(&inside, b, a);
            if area(&outside) > dust {
                out.push(outside);
            }
            inside = left_of(&inside, a, b);
        }
    }
    out
}

fn edges(p: &[DVec2]) -> impl Iterator<Item = [DVec2; 2]> + '_ {
    let ends = p.iter().skip(1).chain(p.first());
    p.iter().zip(ends).map(|(&a, &b)| [a, b])
}

/// Returns the convex hull of some points (Andrew 1979, "Another efficient algorithm for convex
/// hulls in two dimensions").
pub(super) fn hull(mut points: Vec<DVec2>) -> FlatPolygon {
    points.sort_by(|a, b| a.x.total_cmp(&b.x).then(a.y.total_cmp(&b.y)));
    let mut out = half_hull(points.iter());
    out.extend(half_hull(points.iter().rev()));
    out
}

/// Returns the part of the hull to the right of the path through sorted points, from the first one
/// up to the last, exclusive.
fn half_hull<'a>(points: impl Iterator<Item = &'a DVec2>) -> FlatPolygon {
    let mut out: FlatPolygon = Vec::new();
    for &p in points {
        // Remove a corner at which the chain does not turn left.
        while let [.., a, b] = out[..]
            && (b - a).perp_dot(p - a) <= 0.0
        {
            out.pop();
        }
        out.push(p);
    }
    out.pop();
    out
}

/// Returns the Minkowski sum of two convex polygons from [`hull`]: all sums of a point of each. Its
/// edges are those of both, in the order of their directions (de Berg, Cheong, van Kreveld,
/// Overmars 2008, "Computational Geometry", 13.3).
pub(super) fn minkowski_sum(p: &[DVec2], q: &[DVec2]) -> FlatPolygon {
    let mut out = Vec::with_capacity(p.len() + q.len());
    if p.is_empty() || q.is_empty() {
        return out;
    }
    // Both start at their corner of least x, so both directions start straight down.
    let (mut i, mut j) = (0, 0);
    while i < p.len() || j < q.len() {
        let corner = [p[i % p.len()], q[j % q.len()]];
        out.push(corner[0] + corner[1]);
        let p_edge = p[(i + 1) % p.len()] - corner[0];
        let q_edge = q[(j + 1) % q.len()] - corner[1];
        let turn = p_edge.perp_dot(q_edge);
        // Advance both if the edges are parallel. (A direction that is not a number can take any
        // branch.)
        let q_is_first = turn < 0.0;
        let p_is_first = turn > 0.0;
        let p_is_next = j == q.len() || (i < p.len() && !q_is_first);
        let q_is_next = i == p.len() || (j < q.len() && !p_is_first);
        i += usize::from(p_is_next);
        j += usize::from(q_is_next);
    }
    out
}

#[cfg(test)]
mod tests {
    use super::{DVec2, area, hull, minkowski_sum};

    /// Returns points on an ellipse, rotated by an angle.
    fn ellipse(count: u32, axes: [f64; 2], turn: f64) -> Vec<DVec2> {
        let rotation = DVec2::from_angle(turn);
        let step = std::f64::consts::TAU / f64::from(count);
        let point = |k| DVec2::from_angle(step * f64::from(k)) * DVec2::from(axes);
        (0..count).map(|k| rotation.rotate(point(k))).collect()
    }

    /// Returns the hull of all sums of two corners, which needs no order of edges.
    fn hull_of_sums(p: &[DVec2], q: &[DVec2]) -> Vec<DVec2> {
        let sums = p.iter().flat_map(|&a| q.iter().map(move |&b| a + b));
        hull(sums.collect())
    }

    #[test]
    fn minkowski_sums_are_hulls_of_all_sums() {
        let shapes = [
            ellipse(16, [1.0, 1.0], 0.1),
            ellipse(16, [1.0, 1e-6], 0.7),
            ellipse(4, [0.3, 0.3], std::f64::consts::FRAC_PI_4),
            ellipse(7, [1e-3, 2.0], 1.5),
            // A vertical and a slanted segment, and a point.
            vec![DVec2::ZERO, DVec2::Y],
            vec![DVec2::X, DVec2::new(-2.0, 0.5)],
            vec![DVec2::new(3.0, -1.0); 4],
        ];
        for p in &shapes {
            for q in &shapes {
                let (p, q) = (hull(p.clone()), hull(q.clone()));
                let sum = minkowski_sum(&p, &q);
                let other = hull_of_sums(&p, &q);
                assert!(
                    (area(&sum) - area(&other)).abs() <= 1e-12 * (1.0 + area(&other)),
                    "{p:?} and {q:?}: {sum:?}, not {other:?}"
                );
                // Corners in the middle of a side depend on rounding. The extent in each direction
                // does not.
                for direction in ellipse(64, [1.0, 1.0], 0.01) {
                    let reach = |p: &[DVec2]| {
                        let dots = p.iter().map(|c| c.dot(direction));
                        dots.fold(f64::NEG_INFINITY, f64::max)
                    };
                    let (mine, theirs) = (reach(&sum), reach(&other));
                    assert!(
                        (mine - theirs).abs() < 1e-12,
                        "{p:?} and {q:?} reach {mine}, not {theirs}, towards {direction}"
                    );
                }
            }
        }
    }
}
