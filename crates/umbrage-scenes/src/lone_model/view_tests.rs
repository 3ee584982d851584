//! Views of more than fifty small models, each written as an OBJ and as a glTF file, and loaded like
//! anybody's.
//!
//! Each model is a list of solids on ground, so that the position of the eye can be tested against
//! what the file contains instead of against rays.

use super::SIZE;
#[cfg(feature = "gltf")]
use crate::gltf::tests::model::{TestModel, U32};
#[cfg(feature = "gltf")]
use serde_json::json;
use std::fmt::Write;
use umbrage_core::glam::{UVec2, Vec3};
use umbrage_core::{Aabb, Camera, Geometry, Scene};

/// A model under construction: its faces, and the facts that its view is tested against.
#[derive(Default)]
struct Model {
    name: String,
    /// Corners, counter-clockwise from the front.
    faces: Vec<Vec<Vec3>>,
    solids: Vec<Aabb>,
    /// A closed box of inner surfaces.
    room: Option<Aabb>,
    /// A hollow that is seen from outside.
    hollow: Option<Aabb>,
    /// Bounds of the ground. `None` without ground in the file.
    ground: Option<Aabb>,
}

impl Model {
    fn new(name: impl Into<String>) -> Self {
        Self {
            name: name.into(),
            ..Self::default()
        }
    }

    /// Adds a face with these corners, counter-clockwise from its front.
    fn face(&mut self, corners: &[Vec3]) {
        self.faces.push(corners.to_vec());
    }

    /// Returns the model as an OBJ file.
    fn obj(&self) -> String {
        let mut text = String::new();
        let mut vertices = 0;
        for face in &self.faces {
            for p in face {
                writeln!(text, "v {} {} {}", p.x, p.y, p.z).unwrap();
            }
            text.push('f');
            for i in 1..=face.len() {
                write!(text, " {}", vertices + i).unwrap();
            }
            text.push('\n');
            vertices += face.len();
        }
        text
    }

    /// Returns the model as a glTF file: a node with one mesh, and neither a camera nor a light.
    #[cfg(feature = "gltf")]
    fn glb(&self) -> Vec<u8> {
        let mut model = TestModel::new();
        let corners = self.faces.iter().flatten();
        let positions: Vec<f32> = corners.flat_map(|p| p.to_array()).collect();
        // Cut each face, which is convex, into a fan of triangles.
        let mut indices: Vec<u8> = Vec::new();
        let mut first = 0_u32;
        for face in &self.faces {
            for i in 1..face.len() as u32 - 1 {
                let triangle = [first, first + i, first + i + 1];
                indices.extend(triangle.iter().flat_map(|index| index.to_le_bytes()));
            }
            first += face.len() as u32;
        }
        let positions = model.floats("VEC3", 3, &positions);
        let indices = model.numbers(U32, "SCALAR", indices.len() / 4, &indices);
        model.mesh(json!({ "attributes": { "POSITION": positions }, "indices": indices }));
        model.node(json!({ "mesh": 0 }));
        model.glb()
    }

    /// Adds a box with its fronts outside, or inside.
    fn faces_of_box(&mut self, min: Vec3, max: Vec3, inside: bool) {
        self.faces_of_box_except(min, max, inside, None);
    }

    /// Adds a box without the upper face along an axis.
    fn faces_of_box_except(&mut self, min: Vec3, max: Vec3, inside: bool, open: Option<usize>) {
        for axis in 0..3 {
            for high in [false, true] {
                if high && open == Some(axis) {
                    continue;
                }
                let corner = |u: bool, v: bool| {
                    let mut p = Vec3::ZERO;
                    let pick = |axis: usize, high: bool| if high { max[axis] } else { min[axis] };
                    p[axis] = pick(axis, high);
                    p[(axis + 1) % 3] = pick((axis + 1) % 3, u);
                    p[(axis + 2) % 3] = pick((axis + 2) % 3, v);
                    p
                };
                let mut corners = [
                    corner(false, false),
                    corner(true, false),
                    corner(true, true),
                    corner(false, true),
                ];
                if high == inside {
                    corners.reverse();
                }
                self.face(&corners);
            }
        }
    }

    fn solid(mut self, min: [f32; 3], max: [f32; 3]) -> Self {
        let (min, max) = (Vec3::from(min), Vec3::from(max));
        self.faces_of_box(min, max, false);
        self.solids.push(Aabb { min, max });
        self
    }

    fn room(mut self, min: [f32; 3], max: [f32; 3]) -> Self {
        let (min, max) = (Vec3::from(min), Vec3::from(max));
        self.faces_of_box(min, max, true);
        self.room = Some(Aabb { min, max });
        self
    }

    /// Adds a room with an opening in its front wall: a door or a window with these bounds along x
    /// and y.
    fn room_with_opening(mut self, size: [f32; 3], x: [f32; 2], y: [f32; 2]) -> Self {
        let (min, max) = (Vec3::ZERO, Vec3::from(size));
        self.faces_of_box_except(min, max, true, Some(2));
        let mut wall = |x: [f32; 2], y: [f32; 2]| {
            let corner = |x: f32, y: f32| Vec3::new(x, y, max.z);
            if x[0] < x[1] && y[0] < y[1] {
                self.face(&[
                    corner(x[0], y[0]),
                    corner(x[0], y[1]),
                    corner(x[1], y[1]),
                    corner(x[1], y[0]),
                ]);
            }
        };
        wall([0.0, x[0]], [0.0, max.y]);
        wall([x[1], max.x], [0.0, max.y]);
        wall(x, [0.0, y[0]]);
        wall(x, [y[1], max.y]);
        self.room = Some(Aabb { min, max });
        self
    }

    /// Adds a container with walls of this thickness, with or without a lid.
    fn container(mut self, size: [f32; 3], wall: f32, with_lid: bool) -> Self {
        let (min, max) = (Vec3::ZERO, Vec3::from(size));
        let open = (!with_lid).then_some(1);
        self.faces_of_box_except(min, max, true, open);
        let top = if with_lid { max.y + wall } else { max.y };
        self.faces_of_box_except(min - wall, (max + wall).with_y(top), false, open);
        self.hollow = Some(Aabb { min, max });
        self
    }

    /// Adds a table, a top on four legs, at x and z: its length, height and width.
    fn table(self, at: [f32; 2], sides: [f32; 3]) -> Self {
        let [x, z] = at;
        let [length, height, width] = sides;
        let [x_0, x_1, z_0, z_1] = [
            x - 0.5 * length,
            x + 0.5 * length,
            z - 0.5 * width,
            z + 0.5 * width,
        ];
        let leg = 0.08 * height;
        let top = 0.93 * height;
        let mut out = self.solid([x_0, top, z_0], [x_1, height, z_1]);
        for x in [x_0, x_1 - leg] {
            for z in [z_0, z_1 - leg] {
                out = out.solid([x, 0.0, z], [x + leg, top, z + leg]);
            }
        }
        out
    }

    /// Adds a square plane with this half side.
    fn plane(mut self, half: f32, y: f32) -> Self {
        self.face(&[
            Vec3::new(-half, y, half),
            Vec3::new(half, y, half),
            Vec3::new(half, y, -half),
            Vec3::new(-half, y, -half),
        ]);
        let [min, max] = [-half, half].map(|side| Vec3::new(side, y, side));
        self.ground = Some(self.ground.unwrap_or(Aabb { min, max }));
        self
    }

    /// Adds terrain: a square grid of cells with this height at each corner.
    fn terrain(mut self, half: f32, cells: usize, height: impl Fn(f32, f32) -> f32) -> Self {
        let at = |i: usize, j: usize| {
            let along = |i: usize| half * (2.0 * i as f32 / cells as f32 - 1.0);
            let (x, z) = (along(i), along(j));
            Vec3::new(x, height(x, z), z)
        };
        let mut bounds = Aabb::EMPTY;
        for i in 0..cells {
            for j in 0..cells {
                let corners = [at(i, j), at(i, j + 1), at(i + 1, j + 1), at(i + 1, j)];
                bounds = bounds.union(&Aabb::from_points(corners));
                self.face(&corners);
            }
        }
        self.ground = Some(bounds);
        self
    }

    /// Adds a tree: a trunk and a crown.
    fn tree(self, x: f32, z: f32, height: f32) -> Self {
        let (trunk, crown) = (0.04 * height, 0.25 * height);
        let middle = 0.4 * height;
        self.solid([x - trunk, 0.0, z - trunk], [x + trunk, middle, z + trunk])
            .solid(
                [x - crown, middle, z - crown],
                [x + crown, height, z + crown],
            )
    }

    /// Loads the model from a file of each format.
    fn load(&self) -> Vec<(&'static str, Scene)> {
        let files = [
            ("model.obj", self.obj().into_bytes()),
            #[cfg(feature = "gltf")]
            ("model.glb", self.glb()),
        ];
        let folder = tempfile::tempdir().unwrap();
        let load = |(name, bytes): (&'static str, Vec<u8>)| {
            let path = folder.path().join(name);
            std::fs::write(&path, bytes).unwrap();
            (name, crate::load(path).unwrap())
        };
        files.into_iter().map(load).collect()
    }

    /// Returns the bounds of what the view is about: the solids above ground, the hollow, or all
    /// of it.
    fn subject(&self, geometry: &Geometry) -> Aabb {
        let all = self.solids.iter().fold(Aabb::EMPTY, |all, b| all.union(b));
        if all.is_empty() {
            return self.hollow.unwrap_or(geometry.bounds());
        }
        let ground = self.ground.map_or(all.min.y, |ground| ground.min.y);
        let min = all.min.with_y(all.min.y.max(ground));
        Aabb { min, ..all }
    }
}

/// Returns boxes and trees on planes of many sizes, yards, towers, towns, rooms and terrain.
fn models() -> Vec<Model> {
    let mut models = on_planes();
    models.extend(lone_and_terrain());
    models.extend(yards_and_towns());
    models.extend(rooms());
    models.extend(furnished_rooms());
    models.extend(hollows());
    models.extend(groves());
    models
}

/// Boxes, towers and trees on planes.
fn on_planes() -> Vec<Model> {
    let mut models = Vec::new();
    for half in [1.0, 4.0, 10.0, 100.0, 1000.0] {
        for (kind, min, max) in [
            ("middle", [-0.5, 0.0, -0.5], [0.5, 1.0, 0.5]),
            ("corner", [0.0, 0.0, 0.1], [0.7, 0.4, 0.9]),
            ("sunk", [-0.4, -0.3, -0.5], [0.5, 2.0, 0.5]),
        ] {
            let name = format!("box {kind} on {half}");
            models.push(Model::new(name).plane(half, 0.0).solid(min, max));
        }
        let name = format!("tower on {half}");
        let tower = Model::new(name).plane(half, 0.0);
        models.push(tower.solid([-0.3, 0.0, -0.3], [0.3, 8.0, 0.3]));
        let name = format!("tree on {half}");
        models.push(Model::new(name).plane(half, 0.0).tree(0.0, 0.0, 3.0));
    }
    models
}

/// Boxes without ground, and terrain without objects.
fn lone_and_terrain() -> Vec<Model> {
    let mut models = Vec::new();
    for scale in [0.01, 1.0, 300.0] {
        let name = format!("lone box of {scale}");
        models.push(Model::new(name).solid([0.0; 3], [scale, 0.6 * scale, scale]));
        let name = format!("terrain of {scale}");
        let hills =
            move |x: f32, z: f32| 0.2 * scale * (3.0 * x / scale).sin() * (4.0 * z / scale).cos();
        models.push(Model::new(name).terrain(scale, 16, hills));
    }
    let slope = |x: f32, z: f32| 0.5 * x + 0.3 * z;
    models.push(Model::new("slope").terrain(10.0, 8, slope));
    let bowl = |x: f32, z: f32| 0.05 * (x * x + z * z);
    models.push(Model::new("valley").terrain(10.0, 16, bowl));
    models
}

/// Walls around yards, and houses along streets.
fn yards_and_towns() -> Vec<Model> {
    let mut models = Vec::new();
    for wall in [0.1, 0.5, 2.0] {
        for height in [1.0, 3.0, 12.0] {
            let name = format!("yard, walls {wall} by {height}");
            let (a, b) = (5.0, 5.0 + wall);
            let yard = Model::new(name).plane(8.0, 0.0);
            models.push(
                yard.solid([-b, 0.0, -b], [b, height, -a])
                    .solid([-b, 0.0, a], [b, height, b])
                    .solid([-b, 0.0, -a], [-a, height, a])
                    .solid([a, 0.0, -a], [b, height, a]),
            );
        }
    }
    for street in [1.0, 4.0] {
        for with_middle in [false, true] {
            let name = format!("town, streets of {street}, {with_middle}");
            let mut town = Model::new(name).plane(30.0, 0.0);
            for i in -2..=2_i8 {
                for j in -2..=2_i8 {
                    if with_middle || i != 0 || j != 0 {
                        let (x, z) = (f32::from(i) * (4.0 + street), f32::from(j) * (4.0 + street));
                        let height = 3.0 + f32::from((i * 3 + j * 5).rem_euclid(7));
                        town = town.solid([x - 2.0, 0.0, z - 2.0], [x + 2.0, height, z + 2.0]);
                    }
                }
            }
            models.push(town);
        }
    }
    models
}

/// Rooms, empty and furnished.
fn rooms() -> Vec<Model> {
    let mut models = Vec::new();
    for size in [
        [4.0, 3.0, 4.0],
        [20.0, 4.0, 8.0],
        [6.0, 12.0, 6.0],
        [40.0, 3.0, 3.0],
    ] {
        let name = format!("room {size:?}");
        models.push(Model::new(name).room([0.0; 3], size));
        let name = format!("furnished room {size:?}");
        let at = |share: f32, axis: usize| share * size[axis];
        models.push(
            Model::new(name)
                .room([0.0; 3], size)
                .solid(
                    [at(0.4, 0), 0.0, at(0.4, 2)],
                    [at(0.6, 0), at(0.4, 1), at(0.6, 2)],
                )
                .solid(
                    [at(0.1, 0), 0.0, at(0.1, 2)],
                    [at(0.2, 0), at(0.9, 1), at(0.2, 2)],
                ),
        );
    }
    models
}

/// Rooms whose centre or most of whose floor is taken, and rooms with openings.
fn furnished_rooms() -> Vec<Model> {
    let room = |name: &str| Model::new(name).room([0.0; 3], [6.0, 3.0, 5.0]);
    let mut columns = Model::new("hall of columns").room([0.0; 3], [12.0, 4.0, 10.0]);
    for i in 0..3_u8 {
        for j in 0..3_u8 {
            let (x, z) = (3.0 * f32::from(i) + 3.0, 2.5 * f32::from(j) + 2.5);
            columns = columns.solid([x - 0.3, 0.0, z - 0.3], [x + 0.3, 4.0, z + 0.3]);
        }
    }
    let opening = |name: &str, x, y| Model::new(name).room_with_opening([6.0, 3.0, 5.0], x, y);
    vec![
        room("table in the middle").table([3.0, 2.5], [1.8, 0.75, 0.9]),
        room("table with chairs")
            .table([3.0, 2.5], [1.8, 0.75, 0.9])
            .table([1.7, 2.5], [0.45, 0.45, 0.45])
            .table([4.3, 2.5], [0.45, 0.45, 0.45]),
        room("block in the middle").solid([2.2, 0.0, 1.9], [3.8, 0.9, 3.1]),
        room("sofa and cupboard")
            .solid([0.5, 0.0, 0.1], [2.6, 0.45, 1.0])
            .solid([0.5, 0.45, 0.1], [2.6, 0.9, 0.3])
            .solid([5.3, 0.0, 1.0], [5.9, 2.2, 3.5]),
        room("pillar in the middle").solid([2.6, 0.0, 2.1], [3.4, 3.0, 2.9]),
        room("wide pillar in the middle").solid([2.0, 0.0, 1.7], [4.0, 3.0, 3.3]),
        columns,
        opening("open door", [2.5, 3.4], [0.0, 2.1]),
        opening("open door, furnished", [4.0, 4.9], [0.0, 2.1])
            .table([3.0, 2.5], [1.8, 0.75, 0.9])
            .solid([0.1, 0.0, 1.0], [0.9, 0.8, 3.2]),
        opening("window", [1.5, 4.5], [0.9, 2.4]),
        opening("window, furnished", [1.5, 4.5], [0.9, 2.4])
            .solid([2.2, 0.0, 1.9], [3.8, 0.9, 3.1]),
    ]
}

/// Containers, which are seen from outside.
fn hollows() -> Vec<Model> {
    let mut models = Vec::new();
    for wall in [0.02, 0.1, 0.4] {
        for with_lid in [false, true] {
            for size in [[2.0, 1.0, 2.0], [4.0, 2.0, 3.0], [1.0, 3.0, 1.0]] {
                let name = format!("container {size:?}, walls {wall}, lid {with_lid}");
                models.push(Model::new(name).container(size, wall, with_lid));
            }
        }
    }
    models.push(Model::new("table").table([0.0, 0.0], [1.8, 0.75, 0.9]));
    let on_plane = Model::new("table on a plane").plane(4.0, 0.0);
    models.push(on_plane.table([0.0, 0.0], [1.8, 0.75, 0.9]));
    models
}

/// Trees in rows, and a trunk through two planes.
fn groves() -> Vec<Model> {
    let mut models = Vec::new();
    for (half, rows) in [(20.0, 2_u8), (50.0, 4), (200.0, 3)] {
        let mut grove = Model::new(format!("grove of {rows} on {half}")).plane(half, 0.0);
        for i in 0..rows {
            for j in 0..rows {
                let place = |i: u8| 5.0 * (f32::from(i) - 0.5 * f32::from(rows - 1));
                grove = grove.tree(place(i), place(j) + 0.7 * f32::from(i), 4.0 + f32::from(j));
            }
        }
        models.push(grove);
    }
    let plates = Model::new("plates and trunk").plane(200.0, 0.0);
    models.push(
        plates
            .plane(32.0, 0.05)
            .solid([-0.2, -1.0, -0.2], [0.2, 5.0, 0.2]),
    );
    models
}

/// Size of the traced images.
const TRACED: UVec2 = UVec2::new(64, 36);

/// Returns the number of pixels that show the geometry, and of those that show solids.
fn hit_pixels(model: &Model, geometry: &Geometry, camera: &Camera) -> [u32; 2] {
    let eye = camera.eye();
    let rays = camera.with_size(TRACED).rays();
    let reach = 2.0 * geometry.bounds().diagonal() + eye.length();
    let mut counts = [0; 2];
    for y in 0..TRACED.y {
        for x in 0..TRACED.x {
            let [fx, fy] = [x, y].map(|i| i as f32 + 0.5);
            let way = (rays.dir + fx * rays.dir_dx + fy * rays.dir_dy).truncate();
            let way = way.normalize() * reach;
            let Some(t) = geometry.bvh().nearest(geometry, eye, way, u32::MAX) else {
                continue;
            };
            let p = eye + way * t;
            let is_on = |b: &Aabb| {
                let slack = 1e-3 * b.diagonal();
                p.cmpge(b.min - slack).all() && p.cmple(b.max + slack).all()
            };
            counts[0] += 1;
            counts[1] += u32::from(model.solids.iter().any(is_on));
        }
    }
    counts
}

#[test]
fn the_eye_is_in_the_open_above_ground_and_sees_the_model() {
    let models = models();
    assert!(models.len() >= 50, "{}", models.len());
    for model in &models {
        for (file, scene) in model.load() {
            check_view(&format!("{}, {file}", model.name), model, &scene);
        }
    }
}

fn check_view(name: &str, model: &Model, scene: &Scene) {
    let geometry = Geometry::bake(scene).unwrap();
    let camera = &scene.cameras[0];
    let eye = camera.eye();
    let contains = |b: &Aabb| eye.cmpge(b.min).all() && eye.cmple(b.max).all();
    assert!(
        !model.solids.iter().any(contains),
        "{name}: in a solid: {eye}"
    );
    let is_in_room = model.room.iter().any(contains);
    assert_eq!(is_in_room, model.room.is_some(), "{name}: {eye}");
    assert!(!model.hollow.iter().any(contains), "{name}: {eye}");
    let floor = scene.meshes.iter().find(|m| m.name == "floor");
    let floor = floor.map(|floor| Aabb::from_points(floor.positions.iter().copied()));
    if let Some(ground) = model.ground.or(floor) {
        let is_over = (eye.cmpge(ground.min) & eye.cmple(ground.max)).bitmask() & 0b101 == 0b101;
        let height = if is_over { ground.max.y } else { ground.min.y };
        assert!(eye.y > height, "{name}: below ground: {eye}");
    }

    let [met, of_objects] = hit_pixels(model, &geometry, camera);
    let all = TRACED.element_product();
    // A tower is narrow in a wide picture; `span` below bounds its height.
    assert!(met * 40 > all, "{name}: {met} of {all} rays hit");
    if model.room.is_some() {
        return;
    }
    let clip_from_world = camera.space().clip_from_world();
    let project = |p| clip_from_world.project_point3(p);
    let subject = model.subject(&geometry);
    // Parts below the ground are not visible.
    let raised = |p: &Vec3| p.with_y(p.y.max(subject.min.y));
    let is_inside = |p: &Vec3| p.cmpge(subject.min).all() && p.cmple(subject.max).all();
    let points = geometry.positions().iter().map(raised).filter(is_inside);
    let Aabb { min, max } = Aabb::from_points(points.map(project));
    assert!(min.z > 0.0 && max.z < 1.0, "{name}: {min}, {max}");
    let reach = min.truncate().abs().max(max.truncate().abs()).max_element();
    assert!(reach < 1.0, "{name}: outside of the view: {min}, {max}");
    // The view is 2 wide and 2 high here.
    let span = (max - min).truncate().max_element();
    assert!(span > 0.6, "{name}: small in the view: {min}, {max}");
    assert!(
        model.solids.is_empty() || of_objects > 10,
        "{name}: {of_objects} rays hit objects"
    );
    assert_eq!(camera.size, SIZE);
}
