//! Tests of the program `umbrage-sun`.

use crate::meshes::options;
use std::{fs, path::Path, process::Command};
use umbrage_surfaces::{
    Facets, Sides, Stated, Suns,
    glam::{DVec3, dvec3},
};

/// A floor of 4 m x 4 m at UTM coordinates, and a plate of 1 m x 1 m, 1 m above its middle.
const MODEL: &str = "
v 691000 5335000 520\nv 691004 5335000 520\nv 691004 5335004 520\nv 691000 5335004 520
v 691001.5 5335001.5 521\nv 691002.5 5335001.5 521\nv 691002.5 5335002.5 521
v 691001.5 5335002.5 521\nf 1 2 3 4\nf 5 6 7 8\n";

/// Runs the program on the model in a folder; returns its success and both outputs.
fn run(folder: &Path, arguments: &[&str]) -> (bool, String) {
    fs::write(folder.join("model.obj"), MODEL).expect("a folder");
    let program = env!("CARGO_BIN_EXE_umbrage-sun");
    let mut command = Command::new(program);
    command.current_dir(folder).arg("model.obj").args(arguments);
    let output = command.output().expect("the program starts");
    let [out, error] = [output.stdout, output.stderr].map(String::from_utf8);
    (
        output.status.success(),
        out.expect("text") + &error.expect("text"),
    )
}

/// Returns a named column of a CSV file.
fn column(csv: &str, name: &str) -> Vec<f64> {
    let mut lines = csv.lines().filter(|line| !line.starts_with('#'));
    let names = lines.next().expect("names");
    let place = names.split(',').position(|n| n == name).expect("a column");
    lines
        .map(|line| line.split(',').nth(place).expect("a field"))
        .map(|field| field.parse().expect("a number"))
        .collect()
}

/// Returns the weighted mean of the lit areas of the model's facets, by the library.
fn mean_lit_areas(folder: &Path) -> (Vec<f64>, Stated) {
    let model = umbrage_scenes::load_triangles(folder.join("model.obj")).expect("a model");
    let facets = Facets::new(&model.vertices, &model.triangles, &options(Sides::Both));
    let facets = facets.expect("a good mesh");
    let directions = [DVec3::Z, dvec3(1.0, 0.0, 2.0)];
    let suns = Suns::with_weights(&directions, &[1.0, 3.0]).expect("good suns");
    let mut lit = vec![0.0; 4];
    let stated = facets.lit_area(&suns, |sun, areas| {
        for (row, area) in areas.iter().enumerate() {
            lit[row] += area.area * suns.weights()[sun] * 0.25;
        }
    });
    (lit, stated)
}

#[test]
fn areas_of_directions_are_those_of_the_library_in_all_formats() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = |name: &str| folder.path().join(name);
    fs::write(at("suns.txt"), "# up, and aslant\n0 0 1\n1, 0, 2, 3\n").expect("a folder");
    let outs = ["a.csv", "a.npy", "a.glb", "a.png"];
    let mut arguments = vec!["--suns", "suns.txt", "--area"];
    arguments.extend(outs.iter().flat_map(|out| ["--out", out]));
    let (good, report) = run(folder.path(), &arguments);
    assert!(good, "{report}");

    let (lit, stated) = mean_lit_areas(folder.path());
    let csv = fs::read_to_string(at("a.csv")).expect("a file");
    assert_eq!(column(&csv, "lit_m2"), lit);
    // The plate shades 1 m² of the floor's 16.
    assert!((lit[0] + lit[1] - 15.0).abs() < 1e-8, "{lit:?}");

    // Each output has the statement.
    let hash = format!("hash {:016x}", stated.hash);
    let note = fs::read_to_string(at("a.npy.txt")).expect("a file");
    for text in [&report, &csv, &note] {
        assert!(text.contains(&hash), "{text}");
    }
    for out in ["a.glb", "a.png"] {
        let bytes = fs::read(at(out)).expect("a file");
        let has_hash = bytes
            .windows(hash.len())
            .any(|part| part == hash.as_bytes());
        assert!(has_hash, "{out}");
    }
    let npy = fs::read(at("a.npy")).expect("a file");
    let numbers: Vec<f64> = npy[npy.len() - 96..]
        .chunks_exact(8)
        .map(|bytes| f64::from_le_bytes(bytes.try_into().expect("8 bytes")))
        .collect();
    assert_eq!((npy.len() - 96) % 64, 0);
    let second: Vec<f64> = numbers.into_iter().skip(1).step_by(3).collect();
    assert_eq!(second, lit);

    // The model is one of four triangles, y up, at its place to 32 bits of its size.
    let model = umbrage_scenes::load_triangles(at("a.glb")).expect("a model");
    assert_eq!((model.vertices.len(), model.triangles.len()), (12, 4));
    let corner = model.vertices[model.triangles[0][1] as usize];
    let expected = dvec3(691_004.0, 520.0, -5_335_000.0);
    assert!(corner.distance(expected) < 1e-6, "{corner}");

    // A second run over leftovers of a killed one gives the same files.
    let before = outs.map(|out| fs::read(at(out)).expect("a file"));
    fs::write(at(".a.csv.part"), "half").expect("a folder");
    fs::write(at("a.png"), "old").expect("a folder");
    assert!(run(folder.path(), &arguments).0);
    assert_eq!(before, outs.map(|out| fs::read(at(out)).expect("a file")));
    assert!(!at(".a.csv.part").exists());
}

#[test]
fn hours_of_a_day_are_those_of_the_place() {
    let folder = tempfile::tempdir().expect("a folder");
    let day = ["--where", "48.1,11.6", "--on", "2026-03-21", "--zone", "1"];
    let (good, report) = run(folder.path(), &[&day[..], &["--out", "h.csv"]].concat());
    assert!(good, "{report}");
    let csv = fs::read_to_string(folder.path().join("h.csv")).expect("a file");
    let hours = column(&csv, "hours");
    // By pvlib 0.16.1, the centre rises at 6:19:46 and sets at 18:22:37, without refraction.
    assert!((hours[2] - 722.85 / 60.0).abs() < 2.0 / 3600.0, "{hours:?}");
    assert!(csv.contains(",6:19:4") && csv.contains("-18:22:3"), "{csv}");
    let window = [
        "--window", "8-16", "--area", "--step", "10m", "--out", "a.csv",
    ];
    let (good, report) = run(folder.path(), &[&day[..], &window].concat());
    assert!(good, "{report}");
    let csv = fs::read_to_string(folder.path().join("a.csv")).expect("a file");
    let hours = column(&csv, "hours");
    assert!((hours[2] - 8.0).abs() < 1e-9, "{hours:?}");
    assert!(hours[0] < 8.0 && hours[0] > 7.0, "{hours:?}");
}

#[test]
fn errors_state_what_is_wrong() {
    let folder = tempfile::tempdir().expect("a folder");
    fs::write(folder.path().join("bad.txt"), "0 0 1\n1 2\n").expect("a folder");
    let day = ["--where", "48.1,11.6", "--on"];
    let cases: [(&[&str], &str); 7] = [
        (&["--suns", "bad.txt"], "line 2: `1 2`"),
        (&["--suns", "none.txt"], "none.txt can't be read"),
        (
            &["--suns", "bad.txt", "--out", "a.xls"],
            "use .csv, .npy, .glb or .png",
        ),
        (&[day[0], day[1], day[2], "2026-02-30"], "2026-02-30"),
        (&[day[0], "148,11", day[2], "2026-03-21"], "148"),
        (
            &[day[0], day[1], day[2], "2026-03-21", "--window", "16-8"],
            "hours of the day",
        ),
        (&[], "--where"),
    ];
    for (arguments, part) in cases {
        let (good, output) = run(folder.path(), arguments);
        assert!(!good && output.contains(part), "{arguments:?}: {output}");
    }
}
