//! Input that can't be used: errors name the row, the fault and the remedy.

use crate::meshes::{Mesh, block, floor, options};
use umbrage_surfaces::{
    Day, Disc, Facets, Options, Points, Sides, Suns, Up, direction_at,
    glam::{DVec3, dvec3},
    metres_of_unit,
};

fn error_of(mesh: &Mesh, options: &Options) -> String {
    Facets::new(&mesh.vertices, &mesh.triangles, options)
        .expect_err("no facets")
        .to_string()
}

#[test]
fn unusable_facets_are_named() {
    let good = options(Sides::Both);
    let empty = error_of(&Mesh::default(), &good);
    assert!(empty.starts_with("facets: are 0 triangles"), "{empty}");

    let mut mesh = floor(1.0, 2);
    mesh.vertices[4].y = f64::NAN;
    let error = error_of(&mesh, &good);
    assert_eq!(error, "vertex 4: is [0, NaN, 0]; use finite numbers");

    let mut mesh = floor(1.0, 2);
    mesh.triangles[3][1] = 9;
    let error = error_of(&mesh, &good);
    assert!(
        error.starts_with("facet 3: has the corners [1, 9, 4] of 9 vertices"),
        "{error}"
    );

    // 64 bits hold 1e-4 m at 1e12 m.
    let far = floor(1.0, 2).moved(|v| v + dvec3(1e12, 0.0, 0.0));
    let error = error_of(&far, &good);
    assert!(
        error.starts_with("coordinates: reach 1.000e12 m"),
        "{error}"
    );
    let tolerant = Options {
        max_error_m: 0.1,
        ..good
    };
    assert!(Facets::new(&far.vertices, &far.triangles, &tolerant).is_ok());

    let settings = Options {
        unit_m: Some(-1.0),
        ..good
    };
    assert!(error_of(&floor(1.0, 1), &settings).starts_with("unit, metres: is -1"));
}

#[test]
fn improbable_units_have_a_suspect() {
    let unstated = Options::default();
    for (side, suspect) in [
        (0.01, "kilometres"),
        (3721.0, "centimetres"),
        (4e4, "millimetres"),
    ] {
        let error = error_of(&floor(side, 1), &unstated);
        assert!(error.contains(suspect), "{side}: {error}");
        // Stated units are trusted.
        floor(side, 1).facets(Sides::Both);
    }
    let mesh = floor(3721.0, 1);
    let centimetres = Options {
        unit_m: Some(metres_of_unit("cm").expect("a unit")),
        ..unstated
    };
    let facets = Facets::new(&mesh.vertices, &mesh.triangles, &centimetres).expect("good facets");
    assert!((facets.area_m2(0) - 0.5 * 37.21 * 37.21).abs() < 1e-9);
    let error = metres_of_unit("parsec").expect_err("no unit");
    assert!(error.starts_with("`parsec` is no unit"), "{error}");
}

#[test]
fn front_sides_need_closed_outward_bodies() {
    let front = options(Sides::Front);
    let mut open = block(1.0, 1.0, 1.0);
    open.triangles.pop();
    let error = error_of(&open, &front);
    assert!(
        error.starts_with("front sides: 3 edges, such as those of facets ["),
        "{error}"
    );

    let mut turned = block(1.0, 1.0, 1.0);
    turned.triangles[5].swap(0, 1);
    assert!(error_of(&turned, &front).contains("turned alike"));

    let mut inverted = block(1.0, 1.0, 1.0);
    let inward = block(1.0, 1.0, 1.0).moved(|v| dvec3(-v.x, v.y, v.z + 5.0));
    inverted.append(&inward);
    let error = error_of(&inverted, &front);
    assert!(
        error.starts_with("front sides: 12 facets, such as [12, 13, 14"),
        "{error}"
    );

    // Facets without an area close nothing, and don't open anything.
    let mut flat = block(1.0, 1.0, 1.0);
    flat.triangles.push([0, 0, 1]);
    assert!(Facets::new(&flat.vertices, &flat.triangles, &front).is_ok());
}

#[test]
fn unusable_points_suns_and_days_are_named() {
    let facets = floor(1.0, 1).facets(Sides::Both);
    let two = [DVec3::ZERO, DVec3::X];
    let points = |positions: &[DVec3], normals: Option<&[DVec3]>| {
        let points = Points::new(&facets, positions, normals);
        points.expect_err("no points").to_string()
    };
    let zero = points(&two, Some(&[DVec3::Z, DVec3::ZERO]));
    assert_eq!(
        zero,
        "normal 1: is zero; pass a direction, or no normals for both sides"
    );
    let few = points(&two, Some(&[DVec3::Z]));
    assert_eq!(
        few,
        "normals: are 1 for 2 points; use one for each point, or none"
    );
    assert!(points(&[DVec3::NAN], None).starts_with("point 0: is [NaN"));
    assert!(points(&[DVec3::splat(1e13)], None).starts_with("coordinates: reach"));

    let error = Suns::new(&[DVec3::Z, DVec3::ZERO]).expect_err("no direction");
    assert!(
        error
            .to_string()
            .starts_with("sun 1: is [0, 0, 0] with the weight 1"),
        "{error}"
    );
    assert!(Suns::new(&[DVec3::splat(1e-300), DVec3::splat(1e300)]).is_ok());
    let [north, east] = [0.0, 90.0].map(|azimuth| direction_at(azimuth, 0.0, Up::Y));
    assert!((north + DVec3::Z).length() < 1e-15 && (east - DVec3::X).length() < 1e-15);

    let at = Points::new(&facets, &two, None).expect("points");
    let hours_fail = |direction: DVec3, day: &Day| {
        let hours = facets.sun_hours(&at, &|_: f64| direction, day, |_| ());
        assert!(hours.is_err(), "{direction} {day:?}");
    };
    hours_fail(DVec3::ZERO, &Day::default());
    let backwards = Day {
        end_s: -1.0,
        ..Day::default()
    };
    hours_fail(DVec3::Z, &backwards);
    let overlapping = Day {
        windows: vec![[0.0, 9.0], [8.0, 10.0]],
        ..Day::default()
    };
    hours_fail(DVec3::Z, &overlapping);
    let wide = Disc {
        radius_degrees: 90.0,
        ..Disc::default()
    };
    assert!(
        facets
            .disc_share(&at, &Suns::new(&[DVec3::Z]).expect("a sun"), &wide)
            .is_err()
    );
}

/// Each answer states its accuracy in one line.
#[test]
fn answers_state_their_accuracy() {
    let facets = floor(1.0, 1).facets(Sides::Both);
    let stated = facets.lit_area(&Suns::new(&[DVec3::Z]).expect("a sun"), |_, _| ());
    let line = stated.to_string();
    assert!(line.starts_with("0 undecided; margin "), "{line}");
    assert!(line.contains("centre of the sun; hash "), "{line}");
}
