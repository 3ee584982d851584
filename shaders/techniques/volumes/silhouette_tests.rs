use super::*;
use crate::techniques::volumes::{
    clip_window::ClipWindow,
    extrusion::{beyond_all, extrude},
};
use glam::DVec3;
use umbrage_core::{Aabb, Camera, glam::UVec2};

/// Reach of volumes, metres.
const REACH: f64 = 100.0;

const SUN: DVec4 = DVec4::new(0.0, 1.0, 0.0, 0.0);

fn silhouette(mesh: &Welded, light: DVec4) -> Silhouette {
    mesh.silhouette(&Shells::find(mesh), light)
}

/// Returns a unit cube at the origin, with fronts outside and separate corners for every face.
fn cube() -> Welded {
    let mut positions = Vec::new();
    let mut triangles = Vec::new();
    for (axis, side) in [(0, 0.0), (0, 1.0), (1, 0.0), (1, 1.0), (2, 0.0), (2, 1.0)] {
        let first = positions.len() as u32;
        for (u, v) in [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)] {
            let mut p = [0.0; 3];
            (p[axis], p[(axis + 1) % 3], p[(axis + 2) % 3]) = (side, u, v);
            positions.push(Vec3::from(p));
        }
        let t = [[0, 1, 2], [0, 2, 3]].map(|t| t.map(|v| v + first));
        triangles.extend(if side > 0.0 {
            t
        } else {
            t.map(|[a, b, c]| [a, c, b])
        });
    }
    Welded::weld(&positions, &triangles)
}

fn flip_all(mesh: &Welded) -> Welded {
    Welded {
        triangles: mesh.triangles.iter().map(|&[a, b, c]| [a, c, b]).collect(),
        ..mesh.clone()
    }
}

/// Returns the corners along the silhouette's edges, in order, if they form one loop.
fn one_loop(s: &Silhouette) -> Option<Vec<u32>> {
    let next = |v: u32| s.edges.iter().find(|e| e.from == v).map(|e| e.to);
    let mut out = vec![s.edges.first()?.from];
    while out.len() <= s.edges.len() {
        let v = next(*out.last()?)?;
        if v == out[0] {
            return (out.len() == s.edges.len()).then_some(out);
        }
        out.push(v);
    }
    None
}

/// Returns whether every edge of the volumes occurs equally often in both directions.
fn is_closed(mesh: &Welded, s: &Silhouette, light: DVec4) -> bool {
    net_edges(extrude(mesh, s, light, None, REACH).triangles.into_iter()).is_empty()
}

#[test]
fn a_cube_seen_from_its_corner_has_a_hexagon_around_it() {
    let mesh = cube();
    for light in [
        DVec4::new(0.6, 0.64, 0.48, 0.0),
        DVec4::new(5.0, 4.0, 3.0, 1.0),
    ] {
        let s = silhouette(&mesh, light);
        assert_eq!((s.caps.len(), s.edges.len()), (6, 6));
        let corners = one_loop(&s).expect("one loop");
        let at = |v: &u32| mesh.positions[*v as usize];
        assert!(
            corners
                .iter()
                .all(|v| at(v) != Vec3::ZERO && at(v) != Vec3::ONE),
            "the nearest and farthest are inside it"
        );
        assert!(s.edges.iter().all(|e| e.count == 1) && s.caps.iter().all(|cap| cap.in_scene));
        assert!(is_closed(&mesh, &s, light));
    }
}

#[test]
fn fronts_inside_make_the_same_volume() {
    let mesh = cube();
    let light = DVec4::new(5.0, 4.0, 3.0, 1.0);
    let out = silhouette(&mesh, light);
    let inside = silhouette(&flip_all(&mesh), light);
    assert_eq!(out.edges, inside.edges);
    assert!(inside.caps.len() == 6 && inside.caps.iter().all(|cap| !cap.in_scene));
}

#[test]
fn a_light_inside_makes_every_triangle_cast() {
    let mesh = cube();
    let light = DVec4::new(0.5, 0.4, 0.3, 1.0);
    let s = silhouette(&mesh, light);
    assert_eq!((s.caps.len(), s.edges.len()), (12, 0));
    assert!(is_closed(&mesh, &s, light));
}

#[test]
fn an_open_quad_is_turned_to_the_light() {
    let corners = [Vec3::ZERO, Vec3::X, Vec3::X + Vec3::Z, Vec3::Z];
    for triangles in [
        [[0, 1, 2], [0, 2, 3]],
        [[0, 2, 1], [0, 3, 2]],
        [[0, 1, 2], [0, 3, 2]],
    ] {
        let mesh = Welded::weld(&corners, &triangles);
        let s = silhouette(&mesh, SUN);
        assert_eq!((s.caps.len(), s.edges.len()), (2, 4), "{triangles:?}");
        assert!(one_loop(&s).is_some());
        assert!(is_closed(&mesh, &s, SUN));
    }
}

#[test]
fn a_box_without_a_lid_has_all_its_edges_twice() {
    let mut mesh = cube();
    mesh.triangles.truncate(10);
    let light = DVec4::new(0.6, 0.64, 0.48, 0.0);
    let s = silhouette(&mesh, light);
    assert_eq!(s.caps.len(), 10);
    assert!(
        s.edges.iter().any(|e| e.count == 2),
        "where a front meets a back, both leave a wall: {:?}",
        s.edges
    );
    assert!(is_closed(&mesh, &s, light));
}

#[test]
fn duplicates_count_twice() {
    let corners = [Vec3::ZERO, Vec3::Z, Vec3::X];
    let mesh = Welded::weld(&corners, &[[0, 1, 2], [0, 1, 2], [0, 2, 1]]);
    let s = silhouette(&mesh, SUN);
    assert!(
        s.edges.len() == 3 && s.edges.iter().all(|e| e.count == 3),
        "{s:?}"
    );
    assert_eq!(s.caps.iter().filter(|cap| cap.in_scene).count(), 2);
    assert!(is_closed(&mesh, &s, SUN));
}

/// One triangle's edge touches two of its neighbours, another's is touched beyond its end. Four
/// corners are on others' edges.
#[test]
fn seams_have_no_walls() {
    let p = |x: f32, z: f32| Vec3::new(x, 0.1 * x + 0.3, z);
    let corners = [
        p(0.0, 0.0),
        p(3.0, 0.0),
        p(1.5, 2.0),
        p(1.0, 0.0),
        p(1.0, -1.0),
        p(2.0, 0.0),
        p(2.0, -1.0),
    ];
    let triangles = [[0, 2, 1], [0, 3, 4], [3, 5, 4], [4, 5, 6], [6, 5, 1]];
    let mesh = Welded::weld(&corners, &triangles);
    let s = silhouette(&mesh, SUN);
    assert_eq!(s.caps.len(), 3 + 4);
    assert_eq!(s.edges.len(), 2 + 3, "the outline alone: {:?}", s.edges);
    assert!(one_loop(&s).is_some() && is_closed(&mesh, &s, SUN));
    let area = |t: &[u32; 3]| {
        let [a, b, c] = t.map(|v| mesh.positions[v as usize]);
        f64::from((b - a).cross(c - a).length())
    };
    let before: f64 = triangles.iter().map(area).sum();
    let after: f64 = s.caps.iter().map(|cap| area(&cap.corners)).sum();
    // Corners were rounded to 32 bits.
    assert!((before - after).abs() < 1e-6, "{before} {after}");
}

#[test]
fn lights_in_a_triangles_plane_cast_nothing_from_it() {
    let mesh = Welded::weld(&[Vec3::ZERO, Vec3::X, Vec3::Z], &[[0, 2, 1]]);
    assert_eq!(
        silhouette(&mesh, DVec4::new(0.25, 0.0, 0.25, 1.0)),
        Silhouette::default()
    );
    assert_eq!(
        silhouette(&mesh, DVec4::new(0.0, 0.0, 0.0, 1.0)),
        Silhouette::default()
    );
    assert_eq!(
        silhouette(&mesh, DVec4::new(0.25, 0.1, 0.25, 1.0))
            .caps
            .len(),
        1
    );
}

#[test]
fn walls_lean_outwards() {
    let mesh = Welded::weld(&[Vec3::ZERO, Vec3::X, Vec3::Z], &[[0, 2, 1]]);
    let light = DVec4::new(0.2, 2.0, 0.3, 1.0);
    let faces = extrude(&mesh, &silhouette(&mesh, light), light, None, REACH);
    assert_eq!(faces.triangles.len(), 2 + 3 * 2);
    // A point of the volume, well below the triangle, must be behind every face.
    let inside = DVec4::new(0.3, -1.0, 0.25, 1.0);
    for t in &faces.triangles {
        let [a, b, c] = t.map(|v| faces.vertices[v as usize].as_dvec4());
        let side = glam::DMat4::from_cols(a, b, c, inside).determinant();
        assert!(side > 0.0, "{t:?}: {side}");
    }
}

/// Walls may end where they leave the window, since volumes may be open outside it.
#[test]
fn volumes_are_closed_as_far_as_they_are_seen() {
    let mesh = cube();
    let eye = Vec3::new(3.0, 2.0, 4.0);
    let size = UVec2::new(64, 48);
    for (light, at) in [
        (DVec4::new(0.8, 0.6, 0.0, 0.0), Vec3::ZERO),
        (DVec4::new(1.5, 3.0, 0.5, 1.0), Vec3::X),
    ] {
        let camera = Camera::perspective(eye, at, Vec3::Y, 0.9, [0.1, 100.0], size).expect("valid");
        let window = ClipWindow::new(&camera.space(), size);
        let faces = extrude(
            &mesh,
            &silhouette(&mesh, light),
            light,
            Some(&window),
            REACH,
        );
        let open = net_edges(faces.triangles.iter().copied());
        assert!(!open.is_empty(), "walls end at the window");
        for edge in open {
            let ends = [edge.from, edge.to].map(|v| faces.vertices[v as usize].as_dvec4());
            assert!(window.hides(ends), "{light}: {ends:?} is visible");
        }
    }
}

/// The nearest point of a far cap is beyond the farthest corner, also for a light right above a
/// wide triangle.
#[test]
fn volumes_that_end_do_so_beyond_everything() {
    let mesh = Welded::weld(
        &[
            Vec3::new(-5.0, 0.0, -5.0),
            Vec3::new(5.0, 0.0, -5.0),
            Vec3::new(0.0, 0.0, 5.0),
        ],
        &[[0, 2, 1]],
    );
    let bounds = Aabb {
        min: Vec3::new(-6.0, -4.0, -6.0),
        max: Vec3::new(6.0, 1.0, 6.0),
    };
    for light in [
        DVec4::new(0.0, 0.2, -1.0, 1.0),
        DVec4::new(3.0, 8.0, 1.0, 1.0),
        DVec4::new(0.6, 0.8, 0.0, 0.0),
    ] {
        let found = silhouette(&mesh, light);
        let reach = beyond_all(&bounds, &mesh, &found, light);
        let faces = extrude(&mesh, &found, light, None, reach);
        assert!(
            net_edges(faces.triangles.iter().copied()).is_empty()
                && faces.vertices.iter().all(|v| v.w == 1.0)
        );
        let [a, b, c] =
            faces.triangles[1].map(|v| faces.vertices[v as usize].as_dvec4().truncate());
        let normal = (b - a).cross(c - a).normalize();
        let beyond = |p: DVec3| normal.dot(p - a);
        // Fronts face outwards, away from the light.
        assert!(
            bounds.corners().all(|p| beyond(p.as_dvec3()) < 0.0),
            "{light}: {reach}"
        );
    }
}
