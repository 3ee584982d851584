//! Errors of coarse steps in time and of sampled facets, in a generated city:
//! `cargo run --release --example coarse`.
//!
//! Prints the tables of `docs/surfaces.md`: hours of sun by steps of seconds to an hour against
//! steps of 5 seconds that are bisected, and lit shares of facets by 1 to 64 regular samples against
//! exact areas.

mod meshes;

use meshes::Mesh;
use std::{error::Error, time::Instant};
use umbrage_surfaces::{
    Day, Facets, Options, Points, Sides, SunHours, Suns, Up, direction_at,
    glam::{DVec2, DVec3, dvec3},
};

/// Houses along a side of the city.
const HOUSES: u32 = 20;
/// Distance of houses, metres.
const DISTANCE: f64 = 20.0;
/// Points whose hours are compared.
const POINTS: usize = 3000;
/// Latitude of Munich, degrees north.
const LATITUDE: f64 = 48.1;
/// Hours of sun that rules demand, minutes.
const DEMANDED: f64 = 120.0;

fn main() -> Result<(), Box<dyn Error>> {
    let options = Options {
        unit_m: Some(1.0),
        sides: Sides::Front,
        ..Options::default()
    };
    let mesh = city();
    let facets = Facets::new(&mesh.vertices, &mesh.triangles, &options)?;
    println!("city: {} facets", facets.count());
    compare_steps(&facets)?;
    compare_samples(&facets)?;
    Ok(())
}

/// Prints errors of hours of sun at the equinox, for facets' centres spread over the city.
fn compare_steps(facets: &Facets) -> Result<(), Box<dyn Error>> {
    let stride = facets.count() / POINTS;
    let rows = (0..POINTS).map(|i| i * stride);
    let centre = |row| facets.corners_m(row).iter().sum::<DVec3>() / 3.0;
    let positions: Vec<DVec3> = rows.clone().map(centre).collect();
    let normals: Vec<DVec3> = rows.map(|row| facets.normal(row)).collect();
    let points = Points::new(facets, &positions, Some(&normals))?;
    let hours = |step_s: f64, bisect_s: f64| {
        let day = Day {
            step_s,
            bisect_s,
            ..Day::default()
        };
        facets.sun_hours(&points, &equinox, &day, |_| ())
    };
    let truth = hours(5.0, 0.001)?;
    let lit: Vec<usize> = (0..POINTS)
        .filter(|&row| truth.minutes(row) > 0.0)
        .collect();
    println!(
        "{} of {POINTS} points see the sun; truth: {}",
        lit.len(),
        truth.stated
    );
    println!(
        "| step | mean, 99 %, worst, min | > 1 min | > 5 min | events missed | 2 h: other verdict | bisected: mean, worst, min |"
    );
    println!("|---|---|--:|--:|--:|--:|---|");
    for step in [10.0, 60.0, 300.0, 600.0, 900.0, 3600.0] {
        // Changes are in the middle between samples, unless they are bisected.
        let sampled = hours(step, step)?;
        let bisected = hours(step, 0.001)?;
        let off = errors(&lit, &sampled, &truth);
        let off_bisected = errors(&lit, &bisected, &truth);
        let above = |limit: f64| off.iter().filter(|&&error| error > limit).count();
        let share = |count: usize| 100.0 * count as f64 / lit.len() as f64;
        let spans = |hours: &SunHours| lit.iter().map(|&row| hours.spans(row).len()).sum::<usize>();
        let missed = 1.0 - spans(&sampled) as f64 / spans(&truth) as f64;
        let is_enough = |hours: &SunHours, row: usize| hours.minutes(row) >= DEMANDED;
        let flips = lit
            .iter()
            .filter(|&&row| is_enough(&sampled, row) != is_enough(&truth, row));
        println!(
            "| {step} s | {:.2}, {:.1}, {:.1} | {:.1} % | {:.1} % | {:.1} % | {:.2} % | {:.3}, {:.1} |",
            mean(&off),
            off[off.len() * 99 / 100],
            off[off.len() - 1],
            share(above(1.0)),
            share(above(5.0)),
            100.0 * missed,
            share(flips.count()),
            mean(&off_bisected),
            off_bisected[off_bisected.len() - 1],
        );
    }
    Ok(())
}

/// Returns the rising errors of minutes.
fn errors(rows: &[usize], hours: &SunHours, truth: &SunHours) -> Vec<f64> {
    let error = |&row: &usize| (hours.minutes(row) - truth.minutes(row)).abs();
    let mut out: Vec<f64> = rows.iter().map(error).collect();
    out.sort_by(f64::total_cmp);
    out
}

fn mean(numbers: &[f64]) -> f64 {
    numbers.iter().sum::<f64>() / numbers.len() as f64
}

/// Returns the direction to the Sun at the equinox, seconds after midnight of solar time.
fn equinox(second: f64) -> DVec3 {
    let (hour_sin, hour_cos) = ((second / 43_200.0 - 1.0) * std::f64::consts::PI).sin_cos();
    let (sin, cos) = LATITUDE.to_radians().sin_cos();
    dvec3(-hour_sin, -hour_cos * sin, hour_cos * cos)
}

/// Prints errors of sampled shares of facets, among those that face the sun.
fn compare_samples(facets: &Facets) -> Result<(), Box<dyn Error>> {
    println!(
        "| sun | samples a facet | mean error | worst | > .05 | lit area | time / exact time |"
    );
    println!("|---|--:|--:|--:|--:|--:|--:|");
    for height in [60.0, 30.0, 15.0, 5.0] {
        let direction = direction_at(215.0, height, Up::Z);
        let sun = Suns::new(&[direction])?;
        let faces_sun = |row: &usize| facets.normal(*row).dot(direction) > 0.0;
        let rows: Vec<usize> = (0..facets.count()).filter(faces_sun).collect();
        let mut exact = Vec::new();
        let start = Instant::now();
        facets.lit_area(&sun, |_, areas| exact = areas.to_vec());
        let exact_time = start.elapsed().as_secs_f64();
        let whole: f64 = rows.iter().map(|&row| exact[row].area).sum();
        for side in [1_u32, 2, 4, 8] {
            let count = (side * side) as usize;
            let of_facet = |&row: &usize| samples(facets.corners_m(row), side);
            let positions: Vec<DVec3> = rows.iter().flat_map(of_facet).collect();
            let normal = |&row: &usize| std::iter::repeat_n(facets.normal(row), count);
            let normals: Vec<DVec3> = rows.iter().flat_map(normal).collect();
            let start = Instant::now();
            let points = Points::new(facets, &positions, Some(&normals))?;
            let lit = facets.lit(&points, &sun, |_| ());
            let time = start.elapsed().as_secs_f64() / exact_time;
            let mut off = Vec::with_capacity(rows.len());
            let mut area = 0.0;
            for (i, &row) in rows.iter().enumerate() {
                let of_facet = i * count..(i + 1) * count;
                let share = of_facet.filter(|&k| lit.is_lit(0, k)).count() as f64 / count as f64;
                off.push((share - exact[row].fraction).abs());
                area += share * facets.area_m2(row);
            }
            let large = off.iter().filter(|&&error| error > 0.05).count() as f64;
            println!(
                "| {height}° | {count} | {:.4} | {:.2} | {:.1} % | {:+.2} % | {time:.1} |",
                mean(&off),
                off.iter().copied().fold(0.0, f64::max),
                100.0 * large / rows.len() as f64,
                100.0 * (area / whole - 1.0),
            );
        }
    }
    Ok(())
}

/// Returns the centres of `side`² equal parts of a triangle.
fn samples(corners: [DVec3; 3], side: u32) -> Vec<DVec3> {
    let [a, b, c] = corners;
    let mut out = Vec::new();
    let n = 3.0 * f64::from(side);
    for i in 0..side {
        for j in 0..side - i {
            let at = |u: f64, v: f64| a + (b - a) * (u / n) + (c - a) * (v / n);
            let [u, v] = [3.0 * f64::from(i), 3.0 * f64::from(j)];
            out.push(at(u + 1.0, v + 1.0));
            // The part that is turned around, but on the last side.
            if i + j + 1 < side {
                out.push(at(u + 2.0, v + 2.0));
            }
        }
    }
    out
}

/// Returns closed houses of different heights on a closed slab of 1 m squares.
fn city() -> Mesh {
    let mut mesh = Mesh::default();
    let side = f64::from(HOUSES) * DISTANCE;
    let squares = side as u32;
    mesh.add_box([squares, squares, 1], |p| {
        p * dvec3(side, side, 1.0) - DVec3::Z
    });
    for i in 0..HOUSES * HOUSES {
        let corner = DVec2::new(f64::from(i % HOUSES), f64::from(i / HOUSES)) * DISTANCE;
        let mix = f64::from(i * 7919 % 1000) / 1000.0;
        let turn = DVec2::from_angle(mix * 17.0 % 1.6);
        let size = dvec3(12.0, 9.0, 6.0 + 14.0 * mix);
        mesh.add_box([8, 6, 8], |p| {
            let p = (p - dvec3(0.5, 0.5, 0.0)) * size;
            let across = turn.rotate(p.truncate()) + corner + DISTANCE / 2.0;
            across.extend(p.z)
        });
    }
    mesh
}
