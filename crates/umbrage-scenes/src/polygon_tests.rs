use super::*;

fn area(corners: &[Vec3], triangles: &[[u32; 3]]) -> Vec3 {
    let at = |i: u32| corners[i as usize];
    triangles
        .iter()
        .map(|&[a, b, c]| (at(b) - at(a)).cross(at(c) - at(a)) * 0.5)
        .sum()
}

/// Returns the sum of the triangles' areas, regardless of orientation.
fn covered_area(corners: &[Vec3], triangles: &[[u32; 3]]) -> f32 {
    triangles
        .iter()
        .map(|&t| area(corners, &[t]).length())
        .sum()
}

fn outline(points: &[[f32; 2]]) -> Vec<Vec3> {
    // Slant the plane, so that the projection matters.
    points
        .iter()
        .map(|&[x, y]| Vec3::new(x, y, 0.5 * x - 0.25 * y + 3.0))
        .collect()
}

fn shapes() -> Vec<Vec<Vec3>> {
    vec![
        outline(&[[0.0, 0.0], [2.0, 0.0], [2.0, 2.0], [0.0, 2.0]]),
        outline(&[[0.0, 0.0], [2.0, 0.0], [0.5, 0.5], [0.0, 2.0]]),
        outline(&[[0.5, 0.5], [0.0, 2.0], [0.0, 0.0], [2.0, 0.0]]),
        outline(&[
            [0.0, 0.0],
            [3.0, 0.0],
            [3.0, 3.0],
            [2.0, 3.0],
            [2.0, 1.0],
            [1.0, 1.0],
            [1.0, 3.0],
            [0.0, 3.0],
        ]),
        outline(&[
            [0.0, 0.0],
            [1.0, 0.0],
            [2.0, 0.0],
            [2.0, 1.0],
            [1.0, 0.2],
            [0.0, 1.0],
        ]),
    ]
}

#[test]
fn concave_polygons_are_covered_once_and_keep_their_side() {
    for shape in shapes() {
        for corners in [shape.clone(), shape.iter().rev().copied().collect()] {
            let triangles = triangulate(&corners);
            assert_eq!(triangles.len(), corners.len() - 2);
            let fan: Vec<_> = (1..corners.len() as u32 - 1)
                .map(|i| [0, i, i + 1])
                .collect();
            // The vector area does not depend on the triangulation. Overlaps and triangles outside
            // increase the scalar area.
            let whole = area(&corners, &fan);
            let parts = covered_area(&corners, &triangles);
            assert!(
                area(&corners, &triangles).distance(whole) < 1e-5,
                "{corners:?}"
            );
            assert!(
                (parts - whole.length()).abs() < 1e-5,
                "{corners:?}: {triangles:?}"
            );
        }
    }
}

#[test]
fn a_fan_of_a_concave_polygon_would_not_pass() {
    let corners = &shapes()[2];
    let fan: Vec<_> = (1..3).map(|i| [0, i, i + 1]).collect();
    assert!(
        (covered_area(&shapes()[1], &[[1, 2, 3], [1, 3, 0]]) - area(&shapes()[1], &fan).length())
            .abs()
            > 0.1
    );
    assert!(
        (covered_area(corners, &[[0, 1, 2], [0, 2, 3]]) - area(corners, &fan).length()).abs()
            < 1e-5
    );
}

#[test]
fn degenerate_polygons_still_give_triangles() {
    let line = outline(&[[0.0, 0.0], [1.0, 0.0], [2.0, 0.0], [3.0, 0.0]]);
    let bow_tie = outline(&[[0.0, 0.0], [1.0, 1.0], [1.0, 0.0], [0.0, 1.0]]);
    let point = vec![Vec3::ONE; 5];
    for corners in [line, bow_tie, point] {
        assert_eq!(triangulate(&corners).len(), corners.len() - 2);
    }
    assert_eq!(triangulate(&[]).len(), 0);
    assert_eq!(triangulate(&[Vec3::ZERO, Vec3::X]).len(), 0);
}
