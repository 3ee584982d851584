//! Points, discs and hours, against rays in brute force and closed forms.

use crate::meshes::{Mesh, Random, city, floor, lumpy_ball, on_threads, sun_at, suns};
use rayon::prelude::*;
use std::f64::consts::{PI, TAU};
use umbrage_surfaces::{
    Day, Disc, Facets, Points, Sides, Suns, Up, direction_at,
    glam::{DVec3, dvec3},
};

/// Returns whether a ray meets a triangle beyond a distance (Möller and Trumbore 1997, "Fast,
/// Minimum Storage Ray/Triangle Intersection").
pub(crate) fn hits(p: DVec3, direction: DVec3, corners: [DVec3; 3], beyond: f64) -> bool {
    let [a, b, c] = corners;
    let [e, f] = [b - a, c - a];
    let q = direction.cross(f);
    let determinant = e.dot(q);
    let s = p - a;
    let u = s.dot(q) / determinant;
    let r = s.cross(e);
    let v = direction.dot(r) / determinant;
    let t = f.dot(r) / determinant;
    u >= 0.0 && v >= 0.0 && u + v <= 1.0 && t > beyond
}

fn points_at(facets: &Facets, positions: &[DVec3]) -> Points {
    Points::new(facets, positions, None).expect("good points")
}

/// Returns random points on facets, as exact as coordinates allow, with the facets.
fn points_on(mesh: &Mesh, count: usize, random: &mut Random) -> Vec<(DVec3, usize)> {
    let mut points = Vec::with_capacity(count);
    for _ in 0..count {
        let row = random.below(mesh.triangles.len() as u64) as usize;
        let [a, b, c] = mesh.corners(row);
        let [mut u, mut v] = [random.unit(), random.unit()];
        if u + v > 1.0 {
            [u, v] = [1.0 - u, 1.0 - v];
        }
        points.push((a + (b - a) * u + (c - a) * v, row));
    }
    points
}

/// Random points at the origin, in UTM coordinates and at 1e6 m: answers differ from brute force in
/// undecided rows only.
#[test]
fn points_agree_with_rays_in_brute_force() {
    const COUNT: usize = 20_000;
    let mut random = Random(9);
    let near = city(12, &mut random);
    let mut undecided = 0;
    for place in [
        DVec3::ZERO,
        dvec3(691_000.3, 5_335_000.7, 520.1),
        DVec3::splat(1e6),
    ] {
        let mesh = near.clone().moved(|v| v + place);
        let facets = mesh.facets(Sides::Both);
        let points = points_on(&mesh, COUNT, &mut random);
        let positions: Vec<DVec3> = points.iter().map(|point| point.0).collect();
        let rows = points_at(&facets, &positions);
        let suns = suns(&[70.0, 30.0, 8.0, 1.0]);
        let lit = facets.lit(&rows, &suns, |_| ());
        let margin = lit.stated.margin_m;
        assert!(margin < 1e-7, "{margin}");
        undecided += lit.stated.undecided;
        for (i, &sun) in suns.directions().iter().enumerate() {
            let off: Vec<usize> = (0..COUNT)
                .into_par_iter()
                .filter(|&row| {
                    let (p, own) = points[row];
                    let others = (0..mesh.triangles.len()).filter(|&other| other != own);
                    // Start beyond the rounding of the point and of other facets in its plane.
                    let is_dark = others.into_iter().any(|other| {
                        let [a, b, c] = mesh.corners(other);
                        let normal = (b - a).cross(c - a).normalize();
                        let beyond = 2.0 * margin / normal.dot(sun).abs();
                        hits(p, sun, [a, b, c], beyond)
                    });
                    is_dark == lit.is_lit(i, row)
                })
                .collect();
            let listed = &lit.stated.undecided_rows;
            for row in off {
                let pair = (i as u32, row as u32);
                assert!(
                    listed.contains(&pair),
                    "{row} at {place} towards {sun}: {}",
                    lit.stated
                );
            }
        }
    }
    // Too many undecided rows would excuse anything. The sun is edge-on to some facets.
    assert!(
        undecided < 100,
        "{undecided} of {} are undecided",
        12 * COUNT
    );
}

/// The margin is not too small: with a point moved by less, only undecided answers change.
#[test]
fn points_at_edges_are_undecided() {
    let mesh = floor(1.0, 1).moved(|v| v + dvec3(1e5, 0.0, 3.0));
    let facets = mesh.facets(Sides::Both);
    let margin = facets.margin_m();
    let at = |offset: f64| dvec3(1e5 + 0.5 + offset, 0.2, 0.0);
    let positions: Vec<DVec3> = [-3.0, -0.2, 0.2, 3.0]
        .map(|steps| at(steps * margin))
        .to_vec();
    let points = points_at(&facets, &positions);
    let lit = facets.lit(&points, &sun_at(DVec3::Z), |_| ());
    let rows: Vec<u32> = lit.stated.undecided_rows.iter().map(|row| row.1).collect();
    assert_eq!(rows, [1, 2], "{}", lit.stated);
    assert!(!lit.is_lit(0, 0) && lit.is_lit(0, 3));
}

#[test]
fn rows_keep_their_order_and_bits_on_any_number_of_threads() {
    let mut random = Random(2);
    let mesh = city(20, &mut random);
    let facets = mesh.facets(Sides::Both);
    let points = points_on(&mesh, 3000, &mut random);
    let positions: Vec<DVec3> = points.iter().map(|point| point.0).collect();
    let reversed: Vec<DVec3> = positions.iter().rev().copied().collect();
    let suns = suns(&[50.0, 20.0]);
    let lit_on = |positions: &[DVec3], threads: usize| {
        on_threads(threads, || {
            let points = points_at(&facets, positions);
            let shares = facets.disc_share(&points, &suns, &Disc::default());
            let shares = shares.expect("a good disc");
            (facets.lit(&points, &suns, |_| ()), shares)
        })
    };
    let (lit, shares) = lit_on(&positions, 1);
    let count: u32 = lit.words(0).iter().map(|word| word.count_ones()).sum();
    assert!((500..2500).contains(&count), "{count}");
    for threads in [2, 16] {
        let (other_lit, other_shares) = lit_on(&positions, threads);
        assert!(
            other_lit == lit && other_shares == shares,
            "{threads} threads"
        );
    }
    // Points that were made for facets with another anchor are in the same places.
    let far = floor(1.0, 1)
        .moved(|v| v + dvec3(5000.0, 0.0, 0.0))
        .facets(Sides::Both);
    let elsewhere = points_at(&far, &positions);
    assert_eq!(facets.lit(&elsewhere, &suns, |_| ()).words(1), lit.words(1));
    let (turned, _) = lit_on(&reversed, 2);
    for sun in 0..2 {
        for row in 0..3000 {
            assert_eq!(turned.is_lit(sun, row), lit.is_lit(sun, 2999 - row));
        }
    }
}

/// Centres of a closed body's facets have normals; those that face away are dark.
#[test]
fn centres_of_closed_bodies_face_the_sun() {
    let mesh = lumpy_ball(8);
    let facets = mesh.facets(Sides::Front);
    let lit = facets.lit(&Points::centres_of(&facets), &suns(&[25.0]), |_| ());
    let sun = suns(&[25.0]).directions()[0];
    for row in 0..facets.count() {
        assert!(facets.normal(row).dot(sun) > 0.0 || !lit.is_lit(0, row));
    }
    // With both sides, and of an open mesh, too.
    let both = mesh.facets(Sides::Both);
    assert_eq!(
        both.lit(&Points::centres_of(&both), &suns(&[25.0]), |_| ())
            .words(0),
        lit.words(0)
    );
}

/// Returns the share of a disc that the first point sees.
fn share(facets: &Facets, points: &Points, suns: &Suns, disc: &Disc) -> f64 {
    let shares = facets.disc_share(points, suns, disc);
    shares.expect("a good disc").shares[0]
}

/// The share of a disc on one side of a line at a distance, in radii, from its centre.
fn segment_share(distance: f64) -> f64 {
    (distance.acos() - distance * (1.0 - distance * distance).sqrt()) / PI
}

/// An upright wall's edge in front of the disc, and a roof's edge: circular segments.
#[test]
fn shares_of_the_disc_have_their_closed_form() {
    let disc = Disc::default();
    let radius = disc.radius_degrees.to_radians().tan();
    for offset in [-0.9, -0.3, 0.0, 0.5, 0.99] {
        // A wall 7 along y. Its edge is next to the sun's centre.
        let edge = 7.0 * radius * offset;
        let mut mesh = Mesh::default();
        mesh.push([[edge, -5.0], [edge, 5.0], [edge + 9.0, 0.0]].map(|[x, z]| dvec3(x, 7.0, z)));
        // One more in front of it, which hides nothing that isn't hidden.
        mesh.push([[edge, -5.0], [edge, 5.0], [edge + 9.0, 0.0]].map(|[x, z]| dvec3(x, 7.0, z)));
        let facets = mesh.facets(Sides::Both);
        let points = points_at(&facets, &[DVec3::ZERO]);
        let sun = sun_at(DVec3::Y);
        let shares = facets.disc_share(&points, &sun, &disc).expect("a disc");
        let difference = shares.shares[0] - (1.0 - segment_share(offset));
        assert!(difference.abs() < 1e-9, "{offset}: {difference:.1e}");
        // With at most one caster the other one is bounded.
        let few = Disc {
            max_casters: 1,
            ..disc
        };
        let bounded = facets.disc_share(&points, &sun, &few).expect("a disc");
        let difference = (bounded.shares[0] - shares.shares[0]).abs();
        assert!(
            difference <= bounded.errors[0] + 1e-12,
            "{offset}: {difference}"
        );
        // The horizon of a point that faces up hides half of a disc at it.
        let facing = Points::new(&facets, &[DVec3::ZERO], Some(&[DVec3::Z])).expect("a point");
        let half = share(&facets, &facing, &sun, &disc);
        assert!(
            (half - 0.5 * shares.shares[0]).abs() < 1e-9,
            "{offset}: {half}"
        );
    }
}

/// Random casters in front of a wide disc, against 40,000 rays.
#[test]
fn shares_of_the_disc_agree_with_rays() {
    let mut random = Random(21);
    let disc = Disc {
        radius_degrees: 20.0,
        ..Disc::default()
    };
    let radius = disc.radius_degrees.to_radians().tan();
    let mut partial = 0;
    for case in 0..30 {
        let mut mesh = Mesh::default();
        for _ in 0..8 {
            let centre = random.vector() + dvec3(0.0, 0.0, 2.0);
            mesh.push([0; 3].map(|_| centre + random.vector() * 0.6));
        }
        let facets = mesh.facets(Sides::Both);
        let points = points_at(&facets, &[DVec3::ZERO]);
        let sun = sun_at(DVec3::Z);
        let share = share(&facets, &points, &sun, &disc);
        let mut seen = 0;
        const RAYS: u32 = 40_000;
        for i in 0..RAYS {
            // A spiral of equal areas (Vogel 1979).
            let ring = radius * ((f64::from(i) + 0.5) / f64::from(RAYS)).sqrt();
            let angle = TAU * f64::from(i) * 0.618_033_988_749_894_9;
            let ray = dvec3(ring * angle.cos(), ring * angle.sin(), 1.0);
            let mut rows = 0..mesh.triangles.len();
            seen += u32::from(!rows.any(|row| hits(DVec3::ZERO, ray, mesh.corners(row), 0.0)));
        }
        let sampled = f64::from(seen) / f64::from(RAYS);
        assert!(
            (share - sampled).abs() < 3e-3,
            "{case}: {share}, sampled {sampled}"
        );
        partial += u32::from(share > 0.05 && share < 0.95);
    }
    assert!(partial > 15, "only {partial} shares are between 0 and 1");
}

/// Below a plate, the penumbra's mean over the disc is that of the plate's edge.
#[test]
fn areas_over_the_disc_have_half_of_the_penumbra() {
    let mut mesh = floor(20.0, 10);
    let count = mesh.triangles.len();
    mesh.append(&floor(6.0, 2).moved(|v| v + dvec3(0.0, 0.0, 4.0)));
    let facets = mesh.facets(Sides::Both);
    let disc = Disc {
        radius_degrees: 2.0,
        ..Disc::default()
    };
    let mut lit = 0.0;
    let mut fractions = Vec::new();
    let sun = sun_at(DVec3::Z);
    let stated = facets
        .lit_area_of_disc(&sun, &disc, |_, areas| {
            lit = areas[..count].iter().map(|facet| facet.area).sum();
            fractions = areas.iter().map(|facet| facet.fraction).collect();
        })
        .expect("a disc");
    // Each direction's image has the plate's area.
    assert!((lit - (400.0 - 36.0)).abs() < 1e-9, "{lit}");
    assert!(fractions.iter().all(|f| (0.0..=1.0).contains(f)));
    assert!(
        stated
            .disc_error
            .is_some_and(|error| error > 0.0 && error < 0.05),
        "{stated}"
    );
}

/// A sun that circles through the zenith once a day, and walls of known height.
#[test]
fn hours_have_their_closed_form() {
    // A wall 10 m high in the plane x = 0, and a point 10 m to its east: shaded below 45 degrees
    // in the west.
    let mut mesh = floor(30.0, 2);
    for half in [
        [[-40.0, 0.0], [40.0, 0.0], [40.0, 10.0]],
        [[-40.0, 0.0], [40.0, 10.0], [-40.0, 10.0]],
    ] {
        mesh.push(half.map(|[y, z]| dvec3(0.0, y, z)));
    }
    let facets = mesh.facets(Sides::Both);
    // Up at 6:00, in the zenith at 12:00, set at 18:00.
    let path = |second: f64| {
        let angle = TAU * (second / 86_400.0 - 0.25);
        dvec3(angle.cos(), 0.0, angle.sin())
    };
    let positions = [dvec3(10.0, 0.3, 0.0), dvec3(-10.0, 0.3, 0.0)];
    let points = Points::new(&facets, &positions, Some(&[DVec3::Z; 2])).expect("good points");
    let day = Day {
        bisect_s: 0.01,
        ..Day::default()
    };
    let hours_of = |day: &Day| {
        let hours = facets.sun_hours(&points, &path, day, |_| ());
        hours.expect("a good day")
    };
    let hours = hours_of(&day);
    for (row, expected) in [[6.0, 15.0], [9.0, 18.0]].into_iter().enumerate() {
        let [span] = hours.spans(row) else {
            panic!("{row}: {:?}", hours.spans(row));
        };
        let [start, end] = span.map(|second| second / 3600.0);
        assert!(
            (start - expected[0]).abs() * 3600.0 < 0.02,
            "{row}: from {start}"
        );
        assert!((end - expected[1]).abs() * 3600.0 < 0.02, "{row}: to {end}");
        assert!((hours.minutes(row) - 540.0).abs() < 1e-3);
        assert!((hours.longest_minutes(row) - 540.0).abs() < 1e-3);
    }
    // Half of the disc: the same times, as the wall's edge is straight.
    let half = Day {
        half_of: Some(Disc::default()),
        ..day.clone()
    };
    let by_disc = hours_of(&half);
    assert!(
        (by_disc.spans(0)[0][1] - 15.0 * 3600.0).abs() < 0.1,
        "{:?}",
        by_disc.spans(0)
    );
    // Windows cut spans.
    let windows = Day {
        windows: vec![
            [8.0 * 3600.0, 10.0 * 3600.0],
            [12.0 * 3600.0, 13.0 * 3600.0],
        ],
        ..day
    };
    let within = hours_of(&windows);
    assert_eq!(within.minutes(0), 180.0);
    assert!((within.minutes(1) - 120.0).abs() < 1e-3);
    assert_eq!(within.longest_minutes(0), 120.0);
    assert_eq!(within.stated.step_s, Some(60.0));
}

/// Spans agree with samples ten times as dense.
#[test]
fn hours_agree_with_dense_samples() {
    let mut random = Random(31);
    let mesh = city(25, &mut random);
    let facets = mesh.facets(Sides::Both);
    let points = points_on(&mesh, 60, &mut random);
    let positions: Vec<DVec3> = points.iter().map(|point| point.0).collect();
    let points = points_at(&facets, &positions);
    let path = |second: f64| {
        let day = second / 86_400.0;
        direction_at(360.0 * day, 50.0 * (TAU * (day - 0.25)).sin(), Up::Z)
    };
    let hours = facets.sun_hours(&points, &path, &Day::default(), |_| ());
    let hours = hours.expect("a good day");
    let mut suns = Vec::new();
    for i in 0..14_400 {
        let direction = path(f64::from(i) * 6.0);
        suns.extend((direction.z > 0.0).then_some(direction));
    }
    let lit = facets.lit(&points, &Suns::new(&suns).expect("directions"), |_| ());
    let mut differences = Vec::new();
    for row in 0..points.count() {
        let dense = (0..suns.len()).filter(|&sun| lit.is_lit(sun, row)).count() as f64 / 10.0;
        differences.push((hours.minutes(row) - dense).abs());
    }
    let mean = differences.iter().sum::<f64>() / differences.len() as f64;
    let worst = differences.iter().copied().fold(0.0, f64::max);
    assert!(
        mean < 0.2 && worst < 2.0,
        "minutes: mean {mean}, worst {worst}"
    );
    assert!((0..60).any(|row| hours.spans(row).len() > 1));
}
