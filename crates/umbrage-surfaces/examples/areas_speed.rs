//! Times and memory of lit areas:
//! `cargo run --release -p umbrage-surfaces --features cli --example areas_speed -- ball 3000000`.
//!
//! Meshes are `ball` (closed, lumpy), `city` (closed houses on a closed slab), `both` (the city
//! from both sides), `plain` (that on a slab of one square a side) and `ground` (the ball, from both
//! sides, on a slab of 300 times its width). The path of a model, y up, is one, too: it has both
//! sides, and the number is the metres of its unit.
//!
//! With `certify` the sum of areas is checked, which takes longer. Each line has the wall time of a
//! sun, and user and system time over the number of threads, which other programs on the machine
//! disturb less.

mod meshes;

use anyhow::{Context as _, Result, bail};
use meshes::Mesh;
use std::{fs, time::Instant};
use umbrage_scenes::load_triangles;
use umbrage_surfaces::{
    Facets, Options, Points, Sides, Suns, Up, direction_at,
    glam::{DVec2, DVec3, dvec3},
};

fn main() -> Result<()> {
    let arguments: Vec<String> = std::env::args().collect();
    let (kind, count, certify) = match &arguments[..] {
        [_, kind, count] => (kind, count, false),
        [_, kind, count, certify] if certify == "certify" => (kind, count, true),
        _ => bail!(
            "usage: areas_speed ball|ground|city|both|plain FACETS [certify], \
             or areas_speed MODEL METRES [certify]"
        ),
    };
    let count: f64 = count
        .parse()
        .with_context(|| format!("`{count}` is not a number"))?;
    let mesh = match kind.as_str() {
        "ball" => ball(count),
        "plain" => city(count, 1),
        "ground" => ball_on_ground(count),
        "city" | "both" => city(count, 20),
        path => model(path, count)?,
    };
    let options = Options {
        unit_m: Some(1.0),
        sides: match kind.as_str() {
            "ball" | "city" => Sides::Front,
            _ => Sides::Both,
        },
        certify,
        ..Options::default()
    };
    let start = Instant::now();
    let facets = Facets::new(&mesh.vertices, &mesh.triangles, &options)?;
    let prepared = start.elapsed().as_secs_f64();
    let count = facets.count();
    println!("{kind}: {count} facets, prepared in {prepared:.2} s");
    drop(mesh);
    for height in [90.0, 60.0, 30.0, 15.0, 5.0] {
        let sun = Suns::new(&[direction_at(33.0, height, Up::Z)])?;
        let start = Instant::now();
        let used = seconds_used();
        let mut lit = 0.0;
        let stated = facets.lit_area(&sun, |_, areas| {
            lit = areas.iter().map(|facet| facet.projected).sum()
        });
        let wall = start.elapsed().as_secs_f64();
        let used = (seconds_used() - used) / threads();
        println!(
            "{height:4} degrees: {wall:6.2} s wall, {used:6.2} s user + system / threads, \
             {:.2} us a facet, {lit:.6e} m2; at most {:.0} bytes a facet; {stated}",
            used / count as f64 * 1e6,
            peak_bytes() / count as f64,
        );
    }
    // Last, as rays need more memory.
    let start = Instant::now();
    let used = seconds_used();
    let points = Points::centres_of(&facets);
    let directions: Vec<DVec3> = (1..=10)
        .map(|i| direction_at(30.0 * f64::from(i), 6.0 * f64::from(i), Up::Z))
        .collect();
    let lit = facets.lit(&points, &Suns::new(&directions)?, |_| ());
    println!(
        "centres under 10 suns: {:.2} s wall, {:.2} s user + system / threads; {}",
        start.elapsed().as_secs_f64(),
        (seconds_used() - used) / threads(),
        lit.stated,
    );
    Ok(())
}

fn threads() -> f64 {
    std::thread::available_parallelism().map_or(1, usize::from) as f64
}

/// Returns user and system time of this process so far, seconds; 0 outside Linux.
fn seconds_used() -> f64 {
    let stat = fs::read_to_string("/proc/self/stat").unwrap_or_default();
    let ticks = |field: usize| {
        // Fields are counted after the name in parentheses.
        let rest = stat.rsplit(')').next().unwrap_or("");
        rest.split_whitespace()
            .nth(field)
            .and_then(|t| t.parse::<f64>().ok())
            .unwrap_or(0.0)
    };
    (ticks(11) + ticks(12)) / 100.0
}

/// Returns the greatest memory of this process so far, bytes; 0 outside Linux.
fn peak_bytes() -> f64 {
    let status = fs::read_to_string("/proc/self/status").unwrap_or_default();
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"));
    let kilobytes = line.and_then(|line| line.split_whitespace().next()?.parse::<f64>().ok());
    kilobytes.unwrap_or(0.0) * 1024.0
}

/// Reads the triangles of a model, y up, whose unit has this many metres.
fn model(path: &str, unit: f64) -> Result<Mesh> {
    let model = load_triangles(path)?;
    let z_up = |v: &DVec3| dvec3(v.x, -v.z, v.y) * unit;
    Ok(Mesh {
        vertices: model.vertices.iter().map(z_up).collect(),
        triangles: model.triangles,
    })
}

/// Returns a ball of a kilometre with bumps, of at least this number of facets.
fn ball(count: f64) -> Mesh {
    let mut mesh = Mesh::default();
    let squares = (count / 12.0).sqrt().ceil() as u32;
    // A cube, blown up.
    mesh.add_box([squares; 3], |p| {
        let p = (p * 2.0 - 1.0).normalize();
        let large = (7.0 * p.x).sin() * (5.0 * p.y + 1.0).cos() + (9.0 * p.z).sin();
        let small = (61.0 * p.x).sin() * (53.0 * p.y).cos() * (57.0 * p.z).sin();
        p * (1000.0 + 80.0 * large + 15.0 * small)
    });
    mesh
}

/// Returns the ball above a slab of 300 times its width, off the middle.
fn ball_on_ground(count: f64) -> Mesh {
    let mut mesh = ball(count);
    let side = 300.0 * 2000.0;
    mesh.add_box([1; 3], |p| {
        (p - dvec3(0.3, 0.6, 1.0)) * dvec3(side, side, 1.0) - DVec3::Z * 1200.0
    });
    mesh
}

/// Returns houses on a slab, whose top has this number of squares along 20 m; 1 for one in all.
fn city(count: f64, squares: u32) -> Mesh {
    let mut mesh = Mesh::default();
    // A house has 5 x 8² squares and a gable, 20 m of ground 20² squares.
    let houses = (count / (2.0 * (5.0 * 64.0 + 64.0 + 400.0))).sqrt().ceil() as u32;
    let side = f64::from(houses) * 20.0;
    let slab = match squares {
        1 => [1; 3],
        _ => [houses * squares, houses * squares, 1],
    };
    mesh.add_box(slab, |p| p * dvec3(side, side, 1.0) - DVec3::Z);
    for y in 0..houses {
        for x in 0..houses {
            let mix = (x * 7919 + y * 104_729) % 1000;
            let height = 6.0 + 14.0 * f64::from(mix) / 1000.0;
            let turn = DVec2::from_angle(f64::from(mix % 17) * 0.1);
            let corner = DVec2::new(f64::from(x), f64::from(y)) * 20.0 + 10.0;
            mesh.add_box([8; 3], |p| {
                let across = turn.rotate(DVec2::new(p.x - 0.5, p.y - 0.5) * 11.0) + corner;
                let gable = 4.0 * p.z * (1.0 - (2.0 * p.x - 1.0).abs());
                across.extend(p.z * height + gable)
            });
        }
    }
    mesh
}
