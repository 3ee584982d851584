//! Meshes for tests, in metres, z up.

use umbrage_surfaces::{
    Facets, Options, Sides, Suns, Up, direction_at,
    glam::{DVec3, dvec3},
};

#[path = "../../examples/meshes/mod.rs"]
mod grids;

pub(crate) use grids::Mesh;

impl Mesh {
    pub(crate) fn facets(&self, sides: Sides) -> Facets {
        let options = options(sides);
        Facets::new(&self.vertices, &self.triangles, &options).expect("a good mesh")
    }

    /// Returns facets whose answers have the identity.
    pub(crate) fn certified_facets(&self, sides: Sides) -> Facets {
        let options = Options {
            certify: true,
            ..options(sides)
        };
        Facets::new(&self.vertices, &self.triangles, &options).expect("a good mesh")
    }

    pub(crate) fn corners(&self, row: usize) -> [DVec3; 3] {
        self.triangles[row].map(|v| self.vertices[v as usize])
    }

    /// Appends a triangle with its own vertices.
    pub(crate) fn push(&mut self, corners: [DVec3; 3]) {
        let first = self.vertices.len() as u32;
        self.vertices.extend(corners);
        self.triangles.push([first, first + 1, first + 2]);
    }

    pub(crate) fn append(&mut self, other: &Self) {
        let first = self.vertices.len() as u32;
        self.vertices.extend(&other.vertices);
        self.triangles
            .extend(other.triangles.iter().map(|t| t.map(|v| v + first)));
    }

    pub(crate) fn moved(mut self, by: impl Fn(DVec3) -> DVec3) -> Self {
        for v in &mut self.vertices {
            *v = by(*v);
        }
        self
    }
}

pub(crate) fn options(sides: Sides) -> Options {
    Options {
        unit_m: Some(1.0),
        sides,
        ..Options::default()
    }
}

/// Deterministic random numbers: SplitMix64 (Steele, Lea and Flood 2014).
pub(crate) struct Random(pub(crate) u64);

impl Random {
    pub(crate) fn bits(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ z >> 30).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ z >> 27).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ z >> 31
    }

    /// Returns a number in 0..1.
    pub(crate) fn unit(&mut self) -> f64 {
        (self.bits() >> 11) as f64 / (1_u64 << 53) as f64
    }

    pub(crate) fn below(&mut self, end: u64) -> u64 {
        self.bits() % end
    }

    /// Returns a vector with coordinates in -1..1.
    pub(crate) fn vector(&mut self) -> DVec3 {
        dvec3(self.unit(), self.unit(), self.unit()) * 2.0 - 1.0
    }
}

/// A square floor around the origin at z = 0, of 2 `grid`² triangles.
pub(crate) fn floor(side: f64, grid: u32) -> Mesh {
    let mut mesh = Mesh::default();
    mesh.add_grid([grid; 2], false, |x, y| dvec3(x - 0.5, y - 0.5, 0.0) * side);
    mesh
}

/// A closed prism over a convex polygon, from z = 0 to its height.
pub(crate) fn prism(base: &[[f64; 2]], height: f64) -> Mesh {
    let mut mesh = Mesh::default();
    let n = base.len() as u32;
    for z in [0.0, height] {
        mesh.vertices
            .extend(base.iter().map(|p| dvec3(p[0], p[1], z)));
    }
    for i in 0..n {
        let j = (i + 1) % n;
        mesh.triangles.extend([[i, j, n + j], [i, n + j, n + i]]);
    }
    for i in 1..n - 1 {
        mesh.triangles
            .extend([[0, i + 1, i], [n, n + i, n + i + 1]]);
    }
    mesh
}

/// A closed box around the z axis on z = 0.
pub(crate) fn block(width: f64, depth: f64, height: f64) -> Mesh {
    let [x, y] = [width / 2.0, depth / 2.0];
    prism(&[[-x, -y], [x, -y], [x, y], [-x, y]], height)
}

/// Random triangles that cross each other.
pub(crate) fn heap(count: usize, size: f64, random: &mut Random) -> Mesh {
    let mut mesh = Mesh::default();
    for _ in 0..count {
        let centre = random.vector();
        mesh.push([0; 3].map(|_| centre + random.vector() * size));
    }
    mesh
}

/// Boxes and sheets on a floor: rotated, touching, crossing and stacked.
pub(crate) fn city(blocks: usize, random: &mut Random) -> Mesh {
    let mut mesh = floor(20.0, 6);
    for i in 0..blocks {
        let [w, d, h] = [0; 3].map(|_| 0.5 + 2.0 * random.unit());
        let mut block = block(w, d, h);
        if i % 3 == 0 {
            // Open: the last two triangles are half of the roof.
            block.triangles.pop();
        }
        let turn = if i % 2 == 0 { 0.0 } else { random.unit() };
        let place = random.vector() * 8.0;
        let up = if i % 5 == 0 { 0.5 } else { 0.0 };
        mesh.append(&block.moved(|v| {
            let [sin, cos] = [turn.sin(), turn.cos()];
            dvec3(
                cos * v.x - sin * v.y + place.x,
                sin * v.x + cos * v.y + place.y,
                v.z + up,
            )
        }));
    }
    mesh
}

/// A closed ball with bumps, of 12 `grid`² triangles.
pub(crate) fn lumpy_ball(grid: u32) -> Mesh {
    let mut mesh = Mesh::default();
    mesh.add_box([grid; 3], |p| {
        let p = (p * 2.0 - 1.0).normalize();
        let bumps = (7.0 * p.x).sin() * (5.0 * p.y + 1.0).cos() + (9.0 * p.z).sin();
        p * (10.0 + bumps)
    });
    mesh
}

/// Suns at these heights (degrees), each at another azimuth.
pub(crate) fn suns(heights: &[f64]) -> Suns {
    let heights = heights.iter().enumerate();
    let directions =
        heights.map(|(i, &height)| direction_at(17.0 + 71.0 * i as f64, height, Up::Z));
    Suns::new(&directions.collect::<Vec<_>>()).expect("directions")
}

/// One sun.
pub(crate) fn sun_at(direction: DVec3) -> Suns {
    Suns::new(&[direction]).expect("a direction")
}

/// Runs a computation on a number of threads.
pub(crate) fn on_threads<T: Send>(threads: usize, compute: impl FnOnce() -> T + Send) -> T {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads);
    pool.build().expect("threads").install(compute)
}
