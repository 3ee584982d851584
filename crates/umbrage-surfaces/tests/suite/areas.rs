//! Lit areas: the identity, closed forms, rays, and another program's polygons.

use crate::{
    meshes::{
        Mesh, Random, block, city, floor, heap, lumpy_ball, on_threads, options, prism, sun_at,
        suns,
    },
    oracle, points,
};
use std::f64::consts::{PI, TAU};
use umbrage_surfaces::{
    Facets, LitArea, Sides, Stated, Up, direction_at,
    glam::{DVec3, dvec3},
};

/// Relative difference up to which the identity holds.
const IDENTITY: f64 = 1e-9;

fn areas_of(facets: &Facets, sun: DVec3) -> (Vec<LitArea>, Stated) {
    let mut out = Vec::new();
    let stated = facets.lit_area(&sun_at(sun), |_, areas| out = areas.to_vec());
    (out, stated)
}

fn areas(mesh: &Mesh, sides: Sides, sun: DVec3) -> Vec<LitArea> {
    areas_of(&mesh.facets(sides), sun).0
}

fn projected(areas: &[LitArea]) -> f64 {
    areas.iter().map(|facet| facet.projected).sum()
}

/// Returns the relative difference of the sum of lit projected areas from the area of the
/// silhouette.
fn identity_error(mesh: &Mesh, areas: &[LitArea], sun: DVec3) -> f64 {
    let rows = 0..mesh.triangles.len();
    let union = oracle::union_area(rows.map(|row| mesh.corners(row)), sun);
    (projected(areas) / union - 1.0).abs()
}

/// Number of small facets close together. With more than 1,024 the mesh has small cells there, and
/// facets wider than these are computed cell by cell.
const SHEETS: usize = 1100;

/// Meshes with their names and sides. Each has facets that are lit in part.
fn scenes() -> Vec<(&'static str, Mesh, Sides)> {
    let mut random = Random(5);
    let mut coplanar = Mesh::default();
    for _ in 0..60 {
        // Triangles in one tilted plane, which overlap.
        let corner = |random: &mut Random| {
            let [x, y] = [random.unit(), random.unit()];
            dvec3(x, y, 0.3 * x + 0.7 * y)
        };
        coplanar.push([0; 3].map(|_| corner(&mut random)));
    }
    let mut touching = floor(6.0, 3);
    // Boxes side by side, on top of each other, and one through another.
    for [x, y, z] in [
        [0.0, 0.0, 0.0],
        [1.0, 0.0, 0.0],
        [0.0, 0.0, 1.0],
        [0.4, 0.4, 0.3],
    ] {
        touching.append(&block(1.0, 1.0, 1.0).moved(|v| v + dvec3(x, y, z)));
    }
    // Wide facets above small ones, below them, through them and in one plane: see `SHEETS`.
    let mut sheets = floor(4.0, 1);
    sheets.append(&floor(1.6, 1));
    sheets.append(&heap(8, 2.0, &mut random));
    sheets.append(&heap(6, 2.0, &mut random).moved(|v| v + DVec3::Z * 3.0));
    let dense = heap(SHEETS, 0.1, &mut random);
    sheets.append(&dense.moved(|v| v * 0.1 + dvec3(0.6, 1.5, 1.0)));
    vec![
        ("sheets", sheets, Sides::Both),
        ("heap", heap(300, 0.3, &mut random), Sides::Both),
        ("large heap", heap(80, 1.5, &mut random), Sides::Both),
        ("coplanar", coplanar, Sides::Both),
        ("touching", touching, Sides::Both),
        ("city", city(40, &mut random), Sides::Both),
        ("ball", lumpy_ball(11), Sides::Front),
        ("ball, both sides", lumpy_ball(6), Sides::Both),
    ]
}

#[test]
fn lit_areas_add_up_to_the_silhouette() {
    // The sun in the planes of many walls, too.
    let mut suns = suns(&[90.0, 60.0, 30.0, 5.0, 0.7]).directions().to_vec();
    suns.extend([[0.0, 4.0], [90.0, 4.0], [270.0, 45.0]].map(|[a, h]| direction_at(a, h, Up::Z)));
    for (name, mesh, sides) in scenes() {
        for &sun in &suns {
            let (lit, stated) = areas_of(&mesh.certified_facets(sides), sun);
            let error = identity_error(&mesh, &lit, sun);
            assert!(error < IDENTITY, "{name}: {error:.1e} towards {sun}");
            // The library's own check, by the union within each cell, agrees with that of all facets.
            let own = stated.identity.expect("certified");
            assert!(own + error < IDENTITY, "{name}: {stated} towards {sun}");
        }
    }
}

/// Clippers that miss one caster, or see one of facets in the same plane twice, fail the identity.
#[test]
fn a_spoilt_clipper_fails_the_identity() {
    let sun = suns(&[40.0]).directions()[0];
    for (name, mesh, sides) in scenes() {
        let good = areas(&mesh, sides, sun);
        let mut noticed = 0;
        let mut relevant = 0;
        for missing in (0..mesh.triangles.len()).step_by(7) {
            let mut fewer = mesh.clone();
            let caster = fewer.triangles.remove(missing);
            let mut spoilt = areas(&fewer, Sides::Both, sun);
            spoilt.insert(missing, good[missing]);
            // Casters that darken nothing aren't missed.
            if projected(&spoilt) > projected(&good) * (1.0 + 1e-8) {
                relevant += 1;
                noticed += u32::from(identity_error(&mesh, &spoilt, sun) > IDENTITY);
            }
            assert_eq!(caster.len(), 3);
        }
        assert!(
            relevant > 1 && noticed == relevant,
            "{name}: {noticed} of {relevant}"
        );
    }
}

#[test]
fn each_facet_agrees_with_another_programs_polygons() {
    for (name, mesh, sides) in scenes() {
        for &sun in suns(&[50.0, 12.0]).directions() {
            for (row, facet) in areas(&mesh, sides, sun).iter().enumerate() {
                // Test all wide facets of the sheets, which are the first ones.
                if row >= 18 && row % 9 != 0 {
                    continue;
                }
                let [a, b, c] = mesh.corners(row);
                let whole = 0.5 * (b - a).cross(c - a).dot(sun);
                if sides == Sides::Front && whole <= 0.0 {
                    continue;
                }
                let difference = facet.projected - oracle::lit_area(&mesh, row, sun);
                // Facets seen edge-on are small across the light, not to begin with.
                let size = (b - a).length_squared().max((c - a).length_squared());
                assert!(
                    difference.abs() < IDENTITY * size,
                    "{name} {row}: {difference:.1e}"
                );
            }
        }
    }
}

/// 4,096 rays per facet in a grid, tested against all triangles.
#[test]
fn each_facet_agrees_with_its_rays() {
    const GRID: u32 = 64;
    let mut count = 0;
    for (name, mesh, sides) in scenes() {
        let sun = suns(&[35.0]).directions()[0];
        let mut differences = Vec::new();
        for (row, facet) in areas(&mesh, sides, sun).iter().enumerate() {
            let is_partly_lit = facet.fraction > 0.02 && facet.fraction < 0.98;
            if !is_partly_lit || differences.len() >= 12 {
                continue;
            }
            let [a, b, c] = mesh.corners(row);
            let mut lit = 0;
            for i in 0..GRID * GRID {
                let [mut u, mut v] =
                    [i % GRID, i / GRID].map(|x| (f64::from(x) + 0.5) / f64::from(GRID));
                if u + v > 1.0 {
                    [u, v] = [1.0 - u, 1.0 - v];
                }
                let p = a + (b - a) * u + (c - a) * v;
                let mut others = (0..mesh.triangles.len()).filter(|&other| other != row);
                // Of facets in the same plane, those before this one are above it.
                let beyond = |other: usize| if other < row { -1e-9 } else { 1e-9 };
                let is_dark = others.any(|o| points::hits(p, sun, mesh.corners(o), beyond(o)));
                lit += u32::from(!is_dark);
            }
            let sampled = f64::from(lit) / f64::from(GRID * GRID);
            differences.push((sampled - facet.fraction).abs());
        }
        count += differences.len();
        let worst = differences.iter().copied().fold(0.0, f64::max);
        // An edge through the facet cuts some 2 of 64 rows of cells: half a cell each at most.
        assert!(worst < 0.02, "{name}: {worst}");
    }
    assert!(count > 60, "only {count} facets are lit in part");
}

#[test]
fn a_box_on_a_floor_has_its_closed_form() {
    const SIDE: f64 = 100.0;
    let [width, depth, height] = [10.0, 6.0, 8.0];
    for grid in [1, 7, 40, 90] {
        let ground = floor(SIDE, grid);
        let count = ground.triangles.len();
        let mut mesh = ground;
        mesh.append(&block(width, depth, height));
        for &sun in suns(&[80.0, 55.0, 33.0, 21.0]).directions() {
            let areas = areas(&mesh, Sides::Both, sun);
            // The box's image on the floor: its base, moved along the shadow of an upright edge.
            let shadow = sun * (height / sun.z);
            let dark = width * depth + shadow.x.abs() * depth + shadow.y.abs() * width;
            let lit: f64 = areas[..count].iter().map(|facet| facet.area).sum();
            let error = (lit - (SIDE * SIDE - dark)) / (SIDE * SIDE);
            assert!(
                error.abs() < 1e-12,
                "grid {grid}: {error:.1e} towards {sun}"
            );
            // The image is symmetric around its middle, which is half way along the shadow.
            let moment: DVec3 = areas[..count].iter().map(|f| f.centroid * f.area).sum();
            let expected = dvec3(shadow.x, shadow.y, 0.0) * (0.5 * dark);
            let error = (moment - expected) / SIDE.powi(3);
            assert!(
                error.length() < 1e-12,
                "grid {grid}: {moment} for {expected}"
            );
        }
    }
}

/// Two walls at a right angle: one shades the other.
#[test]
fn walls_in_an_l_have_their_closed_form() {
    let [length, width, height] = [9.0, 4.0, 5.0];
    let wall = |far: DVec3| {
        let [low, high] = [DVec3::ZERO, DVec3::Z * height];
        [[low, far, far + high], [low, far + high, high]]
    };
    let mut mesh = Mesh::default();
    for corners in [wall(DVec3::Y * length), wall(DVec3::X * width)].concat() {
        mesh.push(corners);
    }
    for sun in [
        dvec3(1.0, -1.0, 0.5),
        dvec3(1.0, -0.4, 0.9),
        dvec3(0.2, -2.0, 0.1),
    ] {
        let sun = sun.normalize();
        let areas = areas(&mesh, Sides::Both, sun);
        // A point of the first wall at y is shaded up to this height less y times the slope.
        let slope = sun.z / -sun.y;
        let reach = length.min(width * -sun.y / sun.x).min(height / slope);
        let dark = height * reach - 0.5 * slope * reach * reach;
        let lit = areas[0].area + areas[1].area;
        let error = (lit - (length * height - dark)) / (length * height);
        assert!(error.abs() < 1e-12, "{error:.1e} towards {sun}");
    }
}

/// Light through a slit between two plates above a floor.
#[test]
fn a_slit_lights_its_own_area() {
    let [slit, length, height] = [0.01, 30.0, 7.0];
    let mut mesh = floor(100.0, 20);
    let count = mesh.triangles.len();
    for side in [-1.0, 1.0] {
        let plate = floor(1.0, 3)
            .moved(|v| dvec3(v.x * 10.0 + side * (5.0 + slit / 2.0), v.y * length, height));
        mesh.append(&plate);
    }
    for &sun in suns(&[70.0, 50.0]).directions() {
        let areas = areas(&mesh, Sides::Both, sun);
        // The plates' images have their areas; between them the slit's image is lit.
        let lit: f64 = areas[..count].iter().map(|facet| facet.area).sum();
        let error = (lit - (1e4 - 2.0 * 10.0 * length)) / 1e4;
        assert!(error.abs() < 1e-12, "{error:.1e} towards {sun}");
    }
}

fn regular_polygon(n: u32, radius: f64) -> Vec<[f64; 2]> {
    let angle = |i: u32| TAU * f64::from(i) / f64::from(n);
    (0..n)
        .map(|i| [radius * angle(i).cos(), radius * angle(i).sin()])
        .collect()
}

/// A prism over a regular polygon, by the polygon's own formula; with more and more corners, the
/// cylinder's.
#[test]
fn prisms_have_their_closed_form_and_converge_to_the_cylinder() {
    const SIDE: f64 = 60.0;
    let [radius, height] = [4.0, 9.0];
    let sun = suns(&[38.0]).directions()[0];
    let shadow = sun * (height / sun.z);
    let along = dvec3(shadow.x, shadow.y, 0.0);
    let mut errors = Vec::new();
    for n in [3, 8, 32, 128] {
        let base = regular_polygon(n, radius);
        let mut mesh = floor(SIDE, 9);
        let count = mesh.triangles.len();
        mesh.append(&prism(&base, height));
        let areas = areas(&mesh, Sides::Both, sun);
        let lit: f64 = areas[..count].iter().map(|facet| facet.area).sum();
        // The base, and what its width sweeps along the shadow.
        let widths = base.iter().map(|p| along.x * p[1] - along.y * p[0]);
        let most = widths.clone().fold(f64::NEG_INFINITY, f64::max);
        let least = widths.fold(f64::INFINITY, f64::min);
        let base_area = 0.5 * f64::from(n) * radius * radius * (TAU / f64::from(n)).sin();
        let expected = SIDE * SIDE - base_area - (most - least);
        let error = (lit - expected) / (SIDE * SIDE);
        assert!(error.abs() < 1e-12, "{n} corners: {error:.1e}");
        let cylinder = SIDE * SIDE - PI * radius * radius - 2.0 * radius * along.length();
        errors.push((lit - cylinder).abs());
    }
    // Four times the corners: a sixteenth of the error, up to the phase of the corners.
    for pair in errors[1..].windows(2) {
        assert!((8.0..40.0).contains(&(pair[0] / pair[1])), "{errors:?}");
    }
}

#[test]
fn answers_have_the_same_bits_on_any_number_of_threads() {
    for (name, mesh, sides) in scenes() {
        let facets = mesh.certified_facets(sides);
        for &sun in suns(&[45.0, 4.0]).directions() {
            let one = on_threads(1, || areas_of(&facets, sun));
            let identity = one.1.identity.expect("certified");
            assert!(identity < IDENTITY, "{name}: {identity:.1e}");
            for threads in [2, 16] {
                let many = on_threads(threads, || areas_of(&facets, sun));
                assert!(many == one, "{name} on {threads} threads");
            }
        }
    }
}

/// A floor below many small casters, casters that meet in a point, and casters with one outline:
/// pieces and lists stay short where halving separates them, and halving ends where it doesn't.
#[test]
fn many_casters_above_one_facet_are_cut_in_time() {
    let mut random = Random(3);
    let small = heap(6000, 0.02, &mut random).moved(|v| v + dvec3(0.0, 0.0, 3.0));
    let mut cone = Mesh::default();
    let ring = regular_polygon(1500, 1.0);
    for (from, to) in ring.iter().zip(ring.iter().cycle().skip(1)) {
        cone.push([
            DVec3::Z * 2.0,
            dvec3(from[0], from[1], 1.0),
            dvec3(to[0], to[1], 1.0),
        ]);
    }
    let mut stack = Mesh::default();
    for i in 0..200 {
        stack.append(&floor(1.7, 1).moved(|v| v + dvec3(0.1, 0.2, 0.5 + 0.01 * f64::from(i))));
    }
    for casters in [small, cone, stack] {
        let mut mesh = floor(4.0, 1);
        mesh.append(&casters);
        for &sun in suns(&[90.0, 30.0]).directions() {
            let error = identity_error(&mesh, &areas(&mesh, Sides::Both, sun), sun);
            assert!(error < IDENTITY, "{error:.1e} towards {sun}");
        }
    }
}

/// Triangles repeated five times. The identity holds for copies much nearer and much farther than
/// the margin. Between, they may darken each other in a cycle, which must be stated.
#[test]
fn near_duplicates_are_undecided() {
    let mut random = Random(77);
    let once = heap(100, 0.3, &mut random);
    let margin = once.facets(Sides::Both).margin_m();
    for (margins, holds) in [(0.1, true), (3.0, false), (1e4, true)] {
        let mut mesh = Mesh::default();
        for row in 0..500 {
            let offset = random.vector() * (margins * margin);
            mesh.push(once.corners(row % 100).map(|corner| corner + offset));
        }
        let facets = mesh.certified_facets(Sides::Both);
        let stated = facets.lit_area(&suns(&[30.0]), |_, _| ());
        let is_close = stated.identity.expect("certified") < IDENTITY;
        assert_eq!(is_close, holds, "{margins} margins: {stated}");
        assert!(
            holds || stated.undecided > 250,
            "{margins} margins: {stated}"
        );
    }
}

/// Meshes with holes, crossings, degenerate and duplicate triangles and inverted normals.
#[test]
fn random_meshes_have_sound_answers() {
    let mut random = Random(11);
    let mut worst: f64 = 0.0;
    let mut closed = 0;
    for case in 0..1000 {
        // Few positions, so that corners coincide and facets overlap in planes.
        let positions = 2 + random.below(4);
        let mut mesh = Mesh::default();
        for _ in 0..1 + random.below(30) {
            let corner = |random: &mut Random| {
                let [x, y, z] = [0; 3].map(|_| random.below(positions) as f64);
                let lift = if case % 3 == 0 {
                    1e-3 * random.unit()
                } else {
                    0.0
                };
                dvec3(x, y, z + lift)
            };
            mesh.push([0; 3].map(|_| corner(&mut random)));
        }
        let sun = if case % 2 == 0 {
            DVec3::Z
        } else {
            random.vector()
        };
        let sun = sun.normalize();
        let facets = mesh.certified_facets(Sides::Both);
        let (areas, stated) = areas_of(&facets, sun);
        for (row, facet) in areas.iter().enumerate() {
            let whole = facets.area_m2(row);
            let is_sound = (0.0..=1.0).contains(&facet.fraction)
                && (0.0..=whole * (1.0 + 1e-12)).contains(&facet.area)
                && (0.0..=facet.area * (1.0 + 1e-9)).contains(&facet.projected)
                && facet.centroid.is_finite();
            assert!(is_sound, "{case} {row}: {facet:?} of {whole}");
        }
        let union = oracle::union_area((0..mesh.triangles.len()).map(|row| mesh.corners(row)), sun);
        let error = (projected(&areas) - union).abs();
        let sum = projected(&areas);
        assert!(
            error < 1e-9 * union.max(1.0),
            "{case}: {sum} for {union}, {stated}"
        );
        // The library's own check of it is independent.
        let identity = stated.identity.expect("certified");
        assert!(identity * sum.max(1.0) < 2e-9, "{case}: {sum}, {stated}");
        worst = worst.max(error);
        // With one side only, such meshes are refused, unless they are closed by chance.
        let front = Facets::new(&mesh.vertices, &mesh.triangles, &options(Sides::Front));
        match front {
            Ok(facets) => closed += usize::from(areas_of(&facets, sun).1.hash != 0),
            Err(error) => assert!(error.to_string().starts_with("front sides: "), "{error}"),
        }
    }
    assert!(closed < 100, "{closed} are closed");
    println!("worst difference of 1,000 meshes: {worst:.1e} m2");
}
