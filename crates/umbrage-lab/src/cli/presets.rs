//! Presets in the user's files.

use crate::cli::{program::Program, usage::Usage};
use crate::compare::NamedPreset;
use anyhow::Result;
use std::path::{Path, PathBuf};
use umbrage_techniques::{Soft, TechniquePreset};

/// Reads the presets in some files. A preset's name is the file's without `.preset.toml` or
/// `.toml`, or the whole file name if a technique has that name.
pub(crate) fn read(program: &Program, files: &[PathBuf]) -> Result<Vec<NamedPreset>> {
    let mut out: Vec<NamedPreset> = Vec::new();
    for file in files {
        let preset = one(program, file)?;
        if out.iter().any(|other| other.name == preset.name) {
            let (file, name) = (file.display(), &preset.name);
            let why =
                format!("--preset `{file}`: another preset is called `{name}`, too; rename a file");
            return Err(Usage(why).into());
        }
        out.push(preset);
    }
    Ok(out)
}

/// Adds a preset of `soft` with this error, called `soft-E`.
pub(crate) fn add_soft(presets: &mut Vec<NamedPreset>, error: f32) -> Result<()> {
    let name = format!("soft-{error}");
    if presets.iter().any(|other| other.name == name) {
        let why = format!(
            "--max-error {error}: a file of --preset is called `{name}`, too; rename the file"
        );
        return Err(Usage(why).into());
    }
    let preset = TechniquePreset::from(Soft { error });
    presets.push(NamedPreset { name, preset });
    Ok(())
}

/// Reads the preset in a file.
pub(crate) fn one(program: &Program, file: &Path) -> Result<NamedPreset> {
    let unusable = |why: String| Usage(format!("--preset `{}`: {why}", file.display()));
    let text = std::fs::read_to_string(file)
        .map_err(|e| unusable(format!("{e}; use a preset file, as written by `plan`")))?;
    let preset = program.catalogue.preset_from_toml(&text);
    let preset = preset.map_err(|e| unusable(e.to_string()))?;
    let is_taken = |name: &str| {
        program
            .catalogue
            .all()
            .iter()
            .any(|e| e.technique.name == name)
    };
    Ok(NamedPreset {
        name: name_of(file, is_taken),
        preset,
    })
}

/// Returns the name of the preset in a file.
fn name_of(file: &Path, is_taken: impl Fn(&str) -> bool) -> String {
    let whole = file.file_name().unwrap_or_default().to_string_lossy();
    let without_toml = whole.strip_suffix(".toml").unwrap_or(&whole);
    let stem = without_toml.strip_suffix(".preset").unwrap_or(without_toml);
    if stem.is_empty() || is_taken(stem) {
        whole.into_owned()
    } else {
        stem.to_owned()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn program() -> Program {
        Program::default()
    }

    fn write_file(name: &str, text: &str) -> (tempfile::TempDir, PathBuf) {
        let dir = tempfile::tempdir().expect("a temporary folder");
        let file = dir.path().join(name);
        std::fs::write(&file, text).expect("writable");
        (dir, file)
    }

    fn refusal_text(files: &[PathBuf]) -> String {
        let error = read(&program(), files).expect_err("refused");
        assert!(error.is::<Usage>(), "the program ends with 2: {error}");
        error.to_string()
    }

    #[test]
    fn presets_are_called_as_their_files() {
        let name = |file: &str| name_of(Path::new(file), |name| name == "pcf");
        assert_eq!(name("target/plan/street.preset.toml"), "street");
        assert_eq!(name("mine.toml"), "mine");
        assert_eq!(name("pcf.toml"), "pcf.toml");
        assert_eq!(name("mine"), "mine");
        let (_dir, file) = write_file("wide.toml", "technique = 'pcf'\nradius = 2");
        let presets = read(&program(), &[file]).expect("a preset");
        assert_eq!(presets[0].name, "wide");
        assert_eq!(presets[0].preset.technique().name(), "pcf");
    }

    #[test]
    fn soft_is_rendered_with_the_error_that_is_requested() {
        let (_dir, file) = write_file("soft-0.02.toml", "technique = 'pcf'");
        let mut presets = read(&program(), &[file]).expect("a preset");
        add_soft(&mut presets, 0.05).expect("another name");
        let soft = presets[1].preset.get::<Soft>();
        assert_eq!(soft, Some(&Soft { error: 0.05 }));
        assert_eq!(presets[1].name, "soft-0.05");
        let twice = add_soft(&mut presets, 0.02).expect_err("a file has its name");
        assert!(twice.is::<Usage>() && twice.to_string().contains("rename the file"));
    }

    #[test]
    fn bad_files_are_refused_with_the_reason() {
        let (_a, unknown) = write_file("a.toml", "technique = 'pfc'");
        assert!(refusal_text(&[unknown]).contains("names an unknown technique"));
        let (_b, field) = write_file("b.toml", "technique = 'pcf'\nradiuss = 2");
        assert!(refusal_text(&[field]).contains("radiuss"));
        let (_c, other) = write_file("c.toml", "not toml");
        assert!(refusal_text(&[other]).contains("c.toml"));
        assert!(refusal_text(&[PathBuf::from("missing.toml")]).contains("missing.toml"));
        let (_d, twice) = write_file("d.toml", "technique = 'pcf'");
        assert!(refusal_text(&[twice.clone(), twice]).contains("another preset is called `d`"));
    }
}
