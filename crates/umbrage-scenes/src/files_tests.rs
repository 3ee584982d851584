use super::*;
use crate::{SceneError, load, parse, read};
use umbrage_core::Scene;

const LIGHT: &str = "[[light]]\nkind = \"directional\"\ndirection = [1, -2, 0.5]\n";
const MODEL: &str = "mtllib looks.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 0 1\nusemtl brick\nf 1/1 2/2 3/3\n";
const LOOKS: &str = "newmtl brick\nKd 0.5 0.25 0\nmap_Kd images/brick.png\n";

fn png(color: [u8; 3]) -> Vec<u8> {
    let mut out = Cursor::new(Vec::new());
    image::RgbImage::from_pixel(2, 2, image::Rgb(color))
        .write_to(&mut out, image::ImageFormat::Png)
        .unwrap();
    out.into_inner()
}

/// A scene file with a model with looks and a box with a texture, and all files that they name, in
/// folders.
fn all() -> Vec<(&'static str, Vec<u8>)> {
    let scene = format!(
        "{LIGHT}[[object]]\nmesh = \"models/tile.obj\"\n[[object]]\nshape = \"box\"\ntexture = \"wood.png\"\n"
    );
    vec![
        ("scene.toml", scene.into_bytes()),
        ("models/tile.obj", MODEL.into()),
        ("models/looks.mtl", LOOKS.into()),
        ("models/images/brick.png", png([255, 0, 0])),
        ("wood.png", png([0, 255, 0])),
    ]
}

/// Returns the files of [`all`] without their folders, as browsers report them.
fn without_folders() -> Vec<(&'static str, Vec<u8>)> {
    let name = |path: &'static str| path.rsplit('/').next().unwrap();
    all()
        .into_iter()
        .map(|(path, bytes)| (name(path), bytes))
        .collect()
}

fn read_all(path: &str, files: Vec<(&'static str, Vec<u8>)>) -> Result<Scene, SceneError> {
    read(path, &files.into_iter().collect::<FilesInMemory>())
}

fn files_without(name: &str) -> Vec<(&'static str, Vec<u8>)> {
    let mut files = without_folders();
    files.retain(|(known, _)| *known != name);
    files
}

#[test]
fn memory_and_disk_give_the_same() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::create_dir_all(folder.path().join("models/images")).unwrap();
    for (path, bytes) in all() {
        std::fs::write(folder.path().join(path), bytes).unwrap();
    }
    for path in ["scene.toml", "models/tile.obj"] {
        let on_disk = load(folder.path().join(path)).unwrap();
        assert!(!on_disk.textures.is_empty(), "{path}");
        assert_eq!(read_all(path, all()).unwrap(), on_disk, "{path}");
        let name = path.rsplit('/').next().unwrap();
        assert_eq!(
            read_all(name, without_folders()).unwrap(),
            on_disk,
            "{name}"
        );
    }
    let text = "[[light]]\nkind = \"point\"\nposition = [0, 3, 0]\n[[object]]\nshape = \"sphere\"";
    assert_eq!(
        read_all("ball.toml", vec![("ball.toml", text.into())]).unwrap(),
        parse(text, "ball.toml", "").unwrap()
    );
}

#[test]
fn what_a_scene_file_names_must_be_there() {
    let refused = |name| {
        read_all("scene.toml", files_without(name))
            .unwrap_err()
            .to_string()
    };
    assert_eq!(
        refused("wood.png"),
        "scene.toml:8: `object.texture`: wood.png: can't be read: is not among the given files; provide it together with the file \
         that names it"
    );
    assert!(
        refused("tile.obj").contains("scene.toml:5: `object.mesh`: models/tile.obj: can't be read")
    );
    assert!(
        refused("scene.toml").contains("scene.toml: can't be read: is not among the given files")
    );
}

#[test]
fn a_model_does_without_looks_that_are_not_there_and_they_are_reported() {
    let missing_of = |left_out: &str| {
        let files: FilesInMemory = files_without(left_out).into_iter().collect();
        let scene = read("tile.obj", &files).unwrap();
        (scene.textures.len(), files.missing_files())
    };
    assert_eq!(missing_of("wood.png"), (1, vec![]));
    assert_eq!(
        missing_of("brick.png"),
        (0, vec![PathBuf::from("images/brick.png")])
    );
    assert_eq!(
        missing_of("looks.mtl"),
        (0, vec![PathBuf::from("looks.mtl")])
    );
}

#[test]
fn names_are_found_in_any_folder_and_case() {
    let files: FilesInMemory = [
        ("a/Wood.PNG", "1"),
        ("a/b/../tile.obj", "2"),
        ("c/tile.obj", "3"),
    ]
    .into_iter()
    .collect();
    let holds = |path: &str| {
        let mut text = String::new();
        let read = files
            .open(Path::new(path))
            .and_then(|mut file| file.read_to_string(&mut text));
        read.map(|_| text)
    };
    for path in [
        "a/Wood.PNG",
        "wood.png",
        "C:/looks/WOOD.png",
        "../a/./wood.png",
    ] {
        assert_eq!(holds(path).unwrap(), "1", "{path}");
    }
    assert_eq!(holds("a/tile.obj").unwrap(), "2");
    assert_eq!(holds("./c/tile.obj").unwrap(), "3");
    let ambiguous = holds("tile.obj").unwrap_err();
    assert_eq!(
        ambiguous.to_string(),
        "could be `a/tile.obj` or `c/tile.obj`"
    );
    assert!(
        files.has(Path::new("tile.obj")),
        "an error follows that names both"
    );
    for path in ["", "..", "tile", "a"] {
        assert_eq!(
            holds(path).unwrap_err().kind(),
            io::ErrorKind::NotFound,
            "{path}"
        );
    }
}

#[test]
fn a_file_of_the_same_path_is_replaced() {
    let mut files = FilesInMemory::default();
    files.insert("a.obj", "1");
    files.insert("./a.obj", "22");
    assert_eq!(format!("{files:?}"), "{\"a.obj\": 2}");
}

#[test]
fn faults_name_the_file() {
    for (name, bytes, word) in [
        ("a.toml", &b"\xff"[..], "UTF-8"),
        ("a.obj", b"f 1 2 3", "a.obj"),
        ("a.png", b"", "is not a .toml"),
    ] {
        let message = read_all(name, vec![(name, bytes.to_vec())])
            .unwrap_err()
            .to_string();
        assert!(message.contains(word), "{message}");
    }
    let mut broken = files_without("brick.png");
    broken.push(("brick.png", b"no picture".to_vec()));
    let message = read_all("tile.obj", broken).unwrap_err().to_string();
    assert!(
        message.contains("images/brick.png: can't be read as a PNG or JPEG image"),
        "{message}"
    );
    let long = vec![b'#'; (16 << 20) + 1];
    let message = read_all("a.toml", vec![("a.toml", long)])
        .unwrap_err()
        .to_string();
    assert!(message.contains("is over 16 MiB long"), "{message}");
}

/// A program's own store, which returns one model for every path.
struct Store;

impl Files for Store {
    fn open(&self, path: &Path) -> io::Result<Box<dyn OpenFile + '_>> {
        match path.extension() {
            Some(ending) if ending == "obj" => Ok(Box::new(Cursor::new(MODEL))),
            _ => Err(io::ErrorKind::NotFound.into()),
        }
    }

    fn help_for_missing(&self) -> &str {
        "pack it"
    }
}

#[test]
fn a_program_may_keep_files_elsewhere() {
    assert_eq!(read("any.obj", &Store).unwrap().name, "any");
    let message = read("any.toml", &Store).unwrap_err().to_string();
    assert!(message.ends_with("; pack it"), "{message}");
}

#[test]
fn folders_are_no_files_on_disk() {
    let folder = tempfile::tempdir().unwrap();
    assert!(!FilesOnDisk.has(folder.path()));
    let error = FilesOnDisk.open(folder.path()).err().expect("no file");
    assert_eq!(error.to_string(), "is not a file");
}
