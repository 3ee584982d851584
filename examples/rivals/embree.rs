//! Lookups of `exact` compared with rays of Embree 4 to the same light from the same pixels, in
//! turn. `embree.sh` fetches Embree's library, compiles `embree.c` and runs this program.
//!
//! `cargo run --release --example embree PROGRAM LIBRARY FOLDER [SCENE]...`: the compiled program,
//! the library, a folder for triangles and rays, and built-in scenes (by default all speed and
//! content scenes). Each light without extent is a row.

use anyhow::{Context, ensure};
use std::{
    fs,
    io::{BufRead, BufReader, Write},
    path::{Path, PathBuf},
    process::{Child, ChildStdin, ChildStdout, Command, Stdio},
    thread,
    time::{Duration, Instant},
};
use umbrage::{
    Aabb, Backend, Geometry, Light, Receivers, Recipe, ShadowTechnique, View,
    cpu::Cpu,
    glam::{UVec2, Vec3},
    light_sample::{LightSampler, ray_origin, segment, unit_square},
    math::dot3,
    techniques::Exact,
};
use umbrage_lab::bench::{Paired, Repetitions, measure_pairs};

const SIZE: UVec2 = UVec2::new(1280, 720);
const LOOKUPS: Repetitions = Repetitions {
    warm_up: 1,
    runs: 5,
};
const BUILDS: Repetitions = Repetitions {
    warm_up: 1,
    runs: 3,
};
/// Required speed of a lookup relative to Embree, as the geometric mean of all rows.
const MEAN_BAR: f64 = 1.5;
/// Greatest fraction of rays with different results. Beyond it, the two traced different rays.
const MOST_OTHER: f64 = 0.01;
/// A light whose lists are built first, so that the work done once for a scene isn't timed.
const OTHER_LIGHT: Light = Light::Point {
    position: Vec3::ZERO,
    radius: 0.0,
};

fn main() -> anyhow::Result<()> {
    // Read the arguments.
    let mut arguments = std::env::args().skip(1);
    let mut next = |what| {
        arguments
            .next()
            .with_context(|| format!("{what} is missing"))
    };
    let program = PathBuf::from(next("the compiled program")?);
    let library = PathBuf::from(next("Embree's library")?);
    let folder = PathBuf::from(next("the folder")?);
    fs::create_dir_all(&folder)?;
    let mut names: Vec<String> = arguments.collect();
    if names.is_empty() {
        let entries = umbrage::scenes::all().iter();
        let large = entries.filter(|entry| entry.kind.is_full_size());
        names.extend(large.map(|entry| entry.name.to_owned()));
    }

    // Measure each light without extent, in turn with Embree.
    println!(
        "| scene | casters | Embree build ms | Embree trace ms | exact build ms | exact lookup ms | build, ratio | lookup, ratio | rays | hidden | \
         differ |"
    );
    println!("|---|--:|--:|--:|--:|--:|--:|--:|--:|--:|--:|");
    let mut ratios: Vec<f64> = Vec::new();
    let mut name_of_library = String::new();
    let mut cpu = Cpu::new();
    for name in &names {
        let scene = umbrage::scenes::by_argument(name)?;
        let geometry = Geometry::bake(&scene)?;
        // Embree's rays have no alpha tests here.
        if geometry.casters_without_holes() != [geometry.casters()] {
            println!("`{name}` is left out: it has alpha tests");
            continue;
        }
        let camera = scene.cameras[0].with_size(SIZE);
        let receivers = cpu.receivers(&camera, &geometry)?;
        for (number, light) in scene.lights.iter().enumerate() {
            if !light.is_ideal() {
                continue;
            }
            let view = View::new(&camera, light, &geometry).with_receivers(&receivers);
            let rays = EmbreeRays::of_view(&view, &geometry, &receivers);
            write_folder(&folder, &geometry, &rays)?;
            let mut embree = Embree::start(&program, &library, &folder)?;
            let row = measure(&mut embree, &mut cpu, &view, &geometry, &rays)?;
            let requested = rays.queried.iter().filter(|&&requested| requested).count();
            println!(
                "| `{}`, {} light {} | {} | {:.0} | {:.1} | {:.0} | {:.1} | {:.2} | {:.2} | {requested} | {} | {} |",
                name,
                light.kind(),
                number + 1,
                geometry.casters().len(),
                row.makes.theirs.min,
                row.lookups.theirs.min,
                row.makes.ours.min,
                row.lookups.ours.min,
                row.makes.ratio,
                row.lookups.ratio,
                row.hidden,
                row.differ
            );
            ratios.push(row.lookups.ratio);
            name_of_library.clone_from(&embree.name);
        }
    }
    ensure!(
        !ratios.is_empty(),
        "none of the scenes has a light without extent"
    );

    // Compare the ratios with the requirement.
    let logarithms: f64 = ratios.iter().map(|ratio| ratio.ln()).sum();
    let mean = (logarithms / ratios.len() as f64).exp();
    let least = ratios.iter().copied().fold(f64::INFINITY, f64::min);
    println!("\n{name_of_library}, {} threads each.", threads());
    println!("Lookups are {mean:.2} times as fast in the geometric mean, at least {least:.2}.");
    ensure!(
        mean >= MEAN_BAR && least > 1.0,
        "required: {MEAN_BAR} in the mean, and 1 everywhere"
    );
    Ok(())
}

/// Measurements of one light.
struct Row {
    makes: Paired,
    lookups: Paired,
    /// Number of pixels whose ray is blocked, by `exact`.
    hidden: usize,
    /// Number of pixels for which Embree's result differs.
    differ: usize,
}

fn measure(
    embree: &mut Embree,
    cpu: &mut Cpu,
    view: &View<'_>,
    geometry: &Geometry,
    rays: &EmbreeRays,
) -> anyhow::Result<Row> {
    let makes = measure_pairs(
        BUILDS,
        || time_rebuild(view, geometry),
        || embree.run_command("build"),
    )?;
    let recipe = Exact::default().recipe(view)?;
    // The first renders of a recipe don't build lists by themselves: build them here, so that
    // lookups are timed.
    recipe.make_tables();
    check_lists(&recipe)?;
    let lookups = measure_pairs(
        LOOKUPS,
        || {
            let timings = cpu.render(view, &recipe)?.timings;
            timings.receive.context("the CPU times its lookups")
        },
        || embree.run_command("trace"),
    )?;

    let mask = cpu.render(view, &recipe)?.mask;
    let ours: Vec<bool> = mask.iter().map(|&lit| lit < 1.0).collect();
    let theirs = embree.answers()?;
    let differ = count_other(&ours, &theirs, &rays.queried);
    check_comparison(&ours, &theirs, &rays.queried)?;
    let requested = rays.queried.iter().filter(|&&requested| requested).count();
    ensure!(
        differ as f64 <= MOST_OTHER * requested as f64,
        "{differ} of {requested} rays have different results: the rays are not the same"
    );
    let none = vec![false; ours.len()];
    Ok(Row {
        makes,
        lookups,
        hidden: count_other(&ours, &none, &rays.queried),
        differ,
    })
}

/// Builds the lists from scratch, and returns the time.
fn time_rebuild(view: &View<'_>, geometry: &Geometry) -> anyhow::Result<Duration> {
    let fresh = geometry.without_hierarchies();
    // Do the work of a new scene first: its boxes, the reach of receivers, the table of corners.
    let warm = View::new(view.camera, &OTHER_LIGHT, &fresh);
    Exact::default().recipe(&warm)?.make_tables();
    let view = View {
        geometry: Some(&fresh),
        ..*view
    };
    let start = Instant::now();
    let recipe = Exact::default().recipe(&view)?;
    recipe.make_tables();
    let taken = start.elapsed();
    check_lists(&recipe)?;
    Ok(taken)
}

/// Returns an error if a recipe's lists are not built.
fn check_lists(recipe: &Recipe) -> anyhow::Result<()> {
    let bytes = recipe.made_table_bytes();
    ensure!(
        bytes > 0,
        "the lists are not built: other work would be timed"
    );
    Ok(())
}

/// Returns the number of rays with different results.
fn count_other(ours: &[bool], theirs: &[bool], requested: &[bool]) -> usize {
    let answers = ours.iter().zip(theirs).zip(requested);
    answers
        .filter(|&((ours, theirs), &requested)| requested && ours != theirs)
        .count()
}

/// Returns an error if the comparison doesn't detect that every seventh result is wrong.
fn check_comparison(ours: &[bool], theirs: &[bool], requested: &[bool]) -> anyhow::Result<()> {
    let is_spoilt = |i: usize| i.is_multiple_of(7);
    let spoilt: Vec<bool> = (0..theirs.len())
        .map(|i| theirs[i] != is_spoilt(i))
        .collect();
    let found = count_other(theirs, &spoilt, requested);
    let expected = (0..theirs.len())
        .filter(|&i| requested[i] && is_spoilt(i))
        .count();
    ensure!(
        found == expected && count_other(ours, ours, requested) == 0,
        "{found} of {expected} wrong results were detected"
    );
    Ok(())
}

/// The rays that `exact` replaces, pixel by pixel.
struct EmbreeRays {
    /// Origins, and vectors from there to the light.
    rays: Vec<[Vec3; 2]>,
    /// `true` for results that require a ray.
    queried: Vec<bool>,
}

impl EmbreeRays {
    fn of_view(view: &View<'_>, geometry: &Geometry, receivers: &Receivers) -> Self {
        let eye = view.camera.eye();
        let light = LightSampler::new(view.light);
        let plane_reach = geometry.receiver_reach();
        // A length beyond all triangles from every origin, for directional lights.
        let far = 2.0
            * geometry
                .bounds()
                .union(&Aabb::from_points([eye]))
                .diagonal();
        let mut out = Self {
            rays: Vec::with_capacity(receivers.len()),
            queried: Vec::with_capacity(receivers.len()),
        };
        for i in 0..receivers.len() {
            let normal = receivers.normal(i);
            let origin = ray_origin(receivers.position(i), normal, eye, plane_reach);
            let ray = segment(&light, origin, unit_square(0, 0), far);
            let faces_light = dot3(normal, ray) > 0.0;
            out.rays.push([origin, ray]);
            out.queried.push(receivers.receives[i] && faces_light);
        }
        out
    }
}

/// Writes casters and rays in the format of `embree.c`, little-endian.
fn write_folder(folder: &Path, geometry: &Geometry, rays: &EmbreeRays) -> anyhow::Result<()> {
    let casters = geometry.run(&geometry.casters());
    let counts = format!(
        "vertices {} triangles {} width {} height {}\n",
        geometry.positions().len(),
        casters.len(),
        SIZE.x,
        SIZE.y
    );
    let flat = rays.rays.as_flattened();
    let requested: Vec<u8> = rays
        .queried
        .iter()
        .map(|&requested| u8::from(requested))
        .collect();
    fs::write(folder.join("counts.txt"), counts)?;
    fs::write(
        folder.join("vertices.f32"),
        bytemuck::cast_slice(geometry.positions()),
    )?;
    fs::write(folder.join("triangles.u32"), bytemuck::cast_slice(casters))?;
    fs::write(folder.join("rays.f32"), bytemuck::cast_slice(flat))?;
    fs::write(folder.join("asked.u8"), requested)?;
    Ok(())
}

/// The running process of `embree.c`.
struct Embree {
    name: String,
    folder: PathBuf,
    child: Child,
    orders: ChildStdin,
    answers: BufReader<ChildStdout>,
}

impl Embree {
    fn start(program: &Path, library: &Path, folder: &Path) -> anyhow::Result<Self> {
        let mut child = Command::new(program)
            .args([library, folder])
            .arg(threads().to_string())
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .spawn()
            .with_context(|| format!("{} can't be started", program.display()))?;
        let orders = child
            .stdin
            .take()
            .context("the process has no standard input")?;
        let answers = child
            .stdout
            .take()
            .context("the process has no standard output")?;
        let mut out = Self {
            name: String::new(),
            folder: folder.to_owned(),
            child,
            orders,
            answers: BufReader::new(answers),
        };
        out.name = out.line()?;
        Ok(out)
    }

    fn line(&mut self) -> anyhow::Result<String> {
        let mut line = String::new();
        self.answers.read_line(&mut line)?;
        ensure!(line.ends_with('\n'), "the program for Embree ended early");
        Ok(line.trim_end().to_owned())
    }

    /// Sends a command, and returns the time that it reports.
    fn run_command(&mut self, order: &str) -> anyhow::Result<Duration> {
        writeln!(self.orders, "{order}")?;
        self.orders.flush()?;
        let milliseconds: f64 = self.line()?.parse()?;
        Ok(Duration::from_secs_f64(milliseconds / 1e3))
    }

    /// Returns whether each pixel's ray was blocked in the last trace.
    fn answers(&self) -> anyhow::Result<Vec<bool>> {
        let bytes = fs::read(self.folder.join("hidden.u8"))?;
        Ok(bytes.iter().map(|&byte| byte != 0).collect())
    }
}

impl Drop for Embree {
    fn drop(&mut self) {
        // Ignore errors: the process may have ended.
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

fn threads() -> usize {
    thread::available_parallelism().map_or(1, usize::from)
}
