//! Convex polygons in the plane: cut, taken from each other, and measured. In 64 bits.

use glam::DVec2;

/// Corners of a convex polygon, counter-clockwise; fewer than three are nothing.
pub(super) type Polygon = Vec<DVec2>;

/// The area of a polygon: positive if its corners run counter-clockwise.
pub(super) fn area(p: &[DVec2]) -> f64 {
    let Some(&first) = p.first() else { return 0.0 };
    // From one corner, so that digits are not lost far from the origin.
    p.windows(2)
        .map(|w| (w[0] - first).perp_dot(w[1] - first))
        .sum::<f64>()
        / 2.0
}

/// Corners in counter-clockwise order, whichever they come in.
pub(super) fn counter_clockwise(mut p: Polygon) -> Polygon {
    if area(&p) < 0.0 {
        p.reverse();
    }
    p
}

/// The part of a polygon to the left of the line from `a` to `b`.
pub(super) fn left_of(p: &[DVec2], a: DVec2, b: DVec2) -> Polygon {
    cut(p, |q| (b - a).perp_dot(q - a))
}

/// The part of a polygon, of points of any kind, where a linear function is at least 0: Sutherland, Hodgman 1974,
/// "Reentrant Polygon Clipping".
pub(super) fn cut<
    P: Copy + std::ops::Sub<Output = P> + std::ops::Add<Output = P> + std::ops::Mul<f64, Output = P>,
>(
    p: &[P],
    side: impl Fn(P) -> f64,
) -> Vec<P> {
    let mut out = Vec::with_capacity(p.len() + 1);
    for (i, &b) in p.iter().enumerate() {
        let a = p[(i + p.len() - 1) % p.len()];
        let a_side = side(a);
        let b_side = side(b);
        if (a_side < 0.0) != (b_side < 0.0) {
            // The edge crosses the line here.
            out.push(a + (b - a) * (a_side / (a_side - b_side)));
        }
        if b_side >= 0.0 {
            out.push(b);
        }
    }
    out
}

/// Whether a point lies in a polygon, or on its edge.
pub(super) fn contains(p: &[DVec2], q: DVec2) -> bool {
    edges(p).all(|[a, b]| (b - a).perp_dot(q - a) >= 0.0)
}

/// Some points in a polygon: the mean of its corners, and one near each corner.
pub(super) fn spread(p: &[DVec2]) -> Vec<DVec2> {
    let middle = p.iter().sum::<DVec2>() / p.len().max(1) as f64;
    std::iter::once(middle)
        .chain(p.iter().map(|&corner| middle.lerp(corner, 0.95)))
        .collect()
}

/// The common part of two polygons. Nothing cuts nothing off: what is common with no corners at all is the other polygon.
pub(super) fn common(p: &[DVec2], q: &[DVec2]) -> Polygon {
    edges(q).fold(p.to_vec(), |part, [a, b]| left_of(&part, a, b))
}

/// Returns what is left of `pieces` without `q`. Parts of less area than `dust` are dropped.
pub(super) fn without(pieces: Vec<Polygon>, q: &[DVec2], dust: f64) -> Vec<Polygon> {
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
    (0..p.len()).map(|i| [p[i], p[(i + 1) % p.len()]])
}

/// The least convex polygon around some points: Andrew 1979, "Another efficient algorithm for convex hulls in two
/// dimensions".
pub(super) fn hull(mut points: Vec<DVec2>) -> Polygon {
    points.sort_by(|a, b| a.x.total_cmp(&b.x).then(a.y.total_cmp(&b.y)));
    let mut out = half_hull(points.iter());
    out.extend(half_hull(points.iter().rev()));
    out
}

/// The hull's side to the right of the way through sorted points: from the first one up to the last, which is left out.
fn half_hull<'a>(points: impl Iterator<Item = &'a DVec2>) -> Polygon {
    let mut out: Polygon = Vec::new();
    for &p in points {
        // A corner at which the chain does not turn left is none.
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
