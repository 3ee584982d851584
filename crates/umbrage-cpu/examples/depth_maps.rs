//! Times depth maps of a terrain, a town, and any OBJ files given: least and median of 30 runs, 2048 x 2048 texels.
//!
//! `cargo run --release -p umbrage-cpu --example depth_maps -- [--threads N] [FILE.obj...]`

use std::{fmt::Write, time::Instant};
use umbrage_core::{
    Cast, Cull, Extents, Geometry, Instance, LightSpace, Mesh, RasterBias, Scene,
    glam::{Affine3A, UVec2, Vec3},
    light_space::{look_along, orthographic},
};
use umbrage_cpu::{Cpu, CpuOptions};

type Failure = Box<dyn std::error::Error>;

fn main() -> Result<(), Failure> {
    let (mut threads, mut files) = (2, Vec::new());
    let mut arguments = std::env::args().skip(1);
    while let Some(argument) = arguments.next() {
        match argument.as_str() {
            "--threads" => threads = arguments.next().ok_or("--threads needs a number")?.parse()?,
            _ => files.push(argument),
        }
    }
    let mut cpu = Cpu::with_options(&CpuOptions::default().threads(threads))?;
    let mut report = String::new();
    if std::env::var("NOGEN").is_err() {
    measure(&mut cpu, "terrain", terrain(708), &mut report)?;
    measure(&mut cpu, "town", town(100), &mut report)?;
    }
    for file in files {
        measure(&mut cpu, &file, read(&file)?, &mut report)?;
    }
    print!("{report}");
    Ok(())
}

fn measure(cpu: &mut Cpu, name: &str, mesh: Mesh, report: &mut String) -> Result<(), Failure> {
    let scene =
        Scene { meshes: vec![mesh], instances: vec![Instance::new(0, Affine3A::IDENTITY)], ..Default::default() };
    let geometry = Geometry::bake(&scene)?;
    let bounds = geometry.bounds();
    let radius = bounds.extent().length() * 0.5;
    let direction = Vec3::new(-0.4, -1.0, -0.3).normalize();
    let eye = bounds.center() - direction * (2.0 * radius);
    let mut widest = 0.0_f32;
    let view_from_world = look_along(eye, direction, Vec3::Y)?;
    for corner in bounds.corners() {
        let p = view_from_world.transform_point3(corner);
        widest = widest.max(p.x.abs()).max(p.y.abs());
    }
    let extents =
        Extents { left: -widest, right: widest, bottom: -widest, top: widest, near: 0.5 * radius, far: 3.5 * radius };
    let space = LightSpace { view_from_world, clip_from_view: orthographic(extents)? };
    let cast = Cast { image: 0, layer: 0, space, cull: Cull::None, bias: RasterBias::default() };
    let size = UVec2::splat(2048);
    let mut image = cpu.cast(&geometry, &cast, size)?;
    let mut times = Vec::new();
    let mut cpus = Vec::new();
    for _ in 0..30 {
        let start = Instant::now();
        let c0 = cpu_ms();
        cpu.cast_into(&geometry, &cast, &mut image)?;
        cpus.push(cpu_ms() - c0);
        times.push(start.elapsed().as_secs_f64() * 1e3);
    }
    let covered = image.texels.iter().filter(|&&z| z < 1.0).count();
    times.sort_by(f64::total_cmp);
    cpus.sort_by(f64::total_cmp);
    write!(report, "cpu {:6.2} ", cpus[0])?;
    let triangles = geometry.triangles().len();
    let part = 100.0 * covered as f64 / f64::from(size.element_product());
    let working = cpu.working_bytes() as f64 / f64::from(1 << 20);
    let (least, median) = (times[0], times[times.len() / 2]);
    writeln!(
        report,
        "{name:>40} {triangles:>8} triangles {part:5.1} % covered: least {least:6.2} ms, median {median:6.2} ms, \
         working memory {working:.1} MiB"
    )?;
    Ok(())
}

/// A rough height field of `2 side^2` triangles.
fn terrain(side: u32) -> Mesh {
    let height = |x: f32, z: f32| (x * 0.05).sin() * 4.0 + (z * 0.07).cos() * 3.0 + (x * 0.9).sin() * (z * 1.1).sin() * 0.3;
    let points = (0..=side).flat_map(|z| (0..=side).map(move |x| (x as f32, z as f32)));
    let positions = points.map(|(x, z)| Vec3::new(x, height(x, z), z)).collect();
    let cells = (0..side).flat_map(|z| (0..side).map(move |x| z * (side + 1) + x));
    let triangles = cells.flat_map(|i| [[i, i + side + 1, i + 1], [i + 1, i + side + 1, i + side + 2]]).collect();
    Mesh { name: "terrain".into(), positions, triangles, ..Default::default() }
}

/// `side^2` boxes of 12 triangles.
fn town(side: u32) -> Mesh {
    let mut mesh = Mesh { name: "town".into(), ..Default::default() };
    for i in 0..side * side {
        let (x, z) = ((i % side) as f32, (i / side) as f32);
        let height = 0.5 + (i.wrapping_mul(2_654_435_761) >> 16) as f32 / 65536.0 * 3.0;
        let base = mesh.positions.len() as u32;
        let corner = |k: u32| {
            Vec3::new(x + 0.7 * (k & 1) as f32, height * (k >> 1 & 1) as f32, z + 0.7 * (k >> 2) as f32)
        };
        mesh.positions.extend((0..8).map(corner));
        let faces = [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]];
        for f in faces.map(|f| f.map(|v| v + base)) {
            mesh.triangles.extend([[f[0], f[1], f[2]], [f[0], f[2], f[3]]]);
        }
    }
    mesh
}

/// Positions and faces of an OBJ file.
fn read(file: &str) -> Result<Mesh, Failure> {
    let mut mesh = Mesh { name: file.into(), ..Default::default() };
    for line in std::fs::read_to_string(file)?.lines() {
        let mut words = line.split_whitespace();
        match words.next() {
            Some("v") => {
                let v: Vec<f32> = words.take(3).map(str::parse).collect::<Result<_, _>>()?;
                mesh.positions.push(Vec3::from_slice(&v));
            }
            Some("f") => {
                let count = mesh.positions.len() as i64;
                let index = |w: &str| w.split('/').next().unwrap_or(w).parse::<i64>();
                let f: Vec<i64> = words.map(index).collect::<Result<_, _>>()?;
                let f: Vec<u32> = f.iter().map(|&i| if i < 0 { count + i } else { i - 1 } as u32).collect();
                mesh.triangles.extend((2..f.len()).map(|k| [f[0], f[k - 1], f[k]]));
            }
            _ => {}
        }
    }
    Ok(mesh)
}

fn cpu_ms() -> f64 {
    let mut sum = 0.0;
    for t in std::fs::read_dir("/proc/self/task").unwrap() {
        let s = std::fs::read_to_string(t.unwrap().path().join("schedstat")).unwrap();
        sum += s.split(' ').next().unwrap().parse::<f64>().unwrap();
    }
    sum / 1e6
}
