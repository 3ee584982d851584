//! The second software driver: Google's SwiftShader, which rounds vertices to the coarsest grid
//! that Vulkan allows.
//!
//! Debian's package of Chromium's common files contains it. The browser isn't needed: the driver's
//! library is extracted from the package into cargo's target folder. Nothing is installed.

use crate::{
    adapter,
    run::{run, target_folder},
};
use anyhow::{Context as _, Result, bail, ensure};
use std::{
    ffi::OsStr,
    fs,
    path::{Path, PathBuf},
    process::{Command, Stdio},
};

/// Part of the name of its adapter.
const ADAPTER: &str = "SwiftShader";
const PACKAGE: &str = "chromium-common";
const LIBRARY: &str = "libvk_swiftshader.so";
/// Path of the library in the package.
const MEMBER: &str = "./usr/lib/chromium/libvk_swiftshader.so";

/// The unpacked driver.
#[derive(Debug)]
pub(crate) struct SwiftShader {
    manifest: PathBuf,
}

impl SwiftShader {
    /// Returns the driver that an earlier run has unpacked; `None` if there is none.
    pub(crate) fn unpacked_driver() -> Result<Option<Self>> {
        let folder = folder()?;
        if !folder.join(LIBRARY).exists() {
            return Ok(None);
        }
        Self::in_folder(&folder).map(Some)
    }

    /// Downloads and unpacks the driver's library from Debian's archive, unless an earlier run did.
    pub(crate) fn fetch_library() -> Result<()> {
        let folder = folder()?;
        if folder.join(LIBRARY).exists() {
            return Ok(());
        }
        let by_hand = format!(
            "or put {LIBRARY} from another source into {}",
            folder.display()
        );
        if !adapter::is_debian() {
            bail!(
                "--install-driver finds {ADAPTER} only in Debian's package {PACKAGE}: use Debian, {by_hand}"
            );
        }
        println!("fetching {ADAPTER} from Debian's package {PACKAGE}");
        fs::create_dir_all(&folder).with_context(|| format!("cannot make {}", folder.display()))?;
        let package = download(&folder)
            .with_context(|| format!("{ADAPTER} could not be fetched: try again, {by_hand}"))?;
        let unpacked = unpack(&package, &folder);
        fs::remove_file(&package)
            .with_context(|| format!("cannot remove {}", package.display()))?;
        unpacked.with_context(|| {
            format!(
                "{} contains no {MEMBER}: get another package, {by_hand}",
                package.display()
            )
        })
    }

    /// Writes the manifest by which Vulkan's loader finds the library, and checks that its adapter
    /// is found.
    fn in_folder(folder: &Path) -> Result<Self> {
        let path = folder.join("vk_swiftshader_icd.json");
        let text = manifest(&folder.join(LIBRARY));
        fs::write(&path, text).with_context(|| format!("cannot write {}", path.display()))?;
        let driver = Self { manifest: path };
        let found = adapter::find_with(|program| driver.select(program))?;
        let name = found.unwrap_or_else(|| "none".to_owned());
        let help = format!(
            "remove {} and run `cargo xtask test --install-driver`",
            folder.display()
        );
        ensure!(
            is_ours(&name),
            "{ADAPTER} in {} has no adapter (found: {name}); {help}",
            folder.display()
        );
        Ok(driver)
    }

    /// Restricts a program to this driver.
    pub(crate) fn select(&self, command: &mut Command) {
        for variable in ["VK_DRIVER_FILES", "VK_ICD_FILENAMES"] {
            command.env(variable, &self.manifest);
        }
        command.env("WGPU_ADAPTER_NAME", ADAPTER);
    }
}

/// Help for a missing driver.
pub(crate) const HELP: &str = "`cargo xtask test --install-driver` fetches it (Debian)";

fn is_ours(adapter: &str) -> bool {
    adapter.contains(ADAPTER)
}

/// Returns the driver's folder, in cargo's target folder.
fn folder() -> Result<PathBuf> {
    Ok(target_folder()?.join("swiftshader"))
}

/// Returns the text of the manifest. Vulkan's loader uses the library's path as written here.
fn manifest(library: &Path) -> String {
    let icd = serde_json::json!({ "library_path": library, "api_version": "1.0.5" });
    serde_json::json!({ "file_format_version": "1.0.0", "ICD": icd }).to_string()
}

/// Downloads the package and returns its file. Updates the list of packages if the download fails,
/// as the list may be missing or old.
fn download(folder: &Path) -> Result<PathBuf> {
    if apt_get_download(folder).is_err() {
        let prefix = adapter::privilege().context("no rights to run `apt-get update`")?;
        run(adapter::apt_get(prefix).arg("update"))?;
        apt_get_download(folder)?;
    }
    for entry in fs::read_dir(folder)?.flatten() {
        let path = entry.path();
        if path.extension() == Some(OsStr::new("deb")) {
            return Ok(path);
        }
    }
    bail!("apt-get downloaded no package")
}

fn apt_get_download(folder: &Path) -> Result<()> {
    let mut command = adapter::apt_get(&[]);
    command.args(["download", PACKAGE]).current_dir(folder);
    run(&mut command)
}

/// Extracts the library from the package.
fn unpack(package: &Path, folder: &Path) -> Result<()> {
    let mut archive = Command::new("dpkg-deb");
    let mut archive = archive
        .arg("--fsys-tarfile")
        .arg(package)
        .stdout(Stdio::piped())
        .spawn()?;
    let tar = archive.stdout.take().context("no pipe")?;
    // Strip the folders of its path.
    let mut out = Command::new("tar");
    out.args(["--extract", "--strip-components=4", "--directory"])
        .arg(folder)
        .arg(MEMBER)
        .stdin(tar);
    let unpacked = run(&mut out);
    // `dpkg-deb` may fail if tar stops reading early, which is no error: only wait for it.
    archive.wait()?;
    unpacked
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_manifest_names_the_library_whatever_its_path() {
        let json: serde_json::Value =
            serde_json::from_str(&manifest(Path::new("/a \"b\"/libx.so"))).expect("valid JSON");
        assert_eq!(json["ICD"]["library_path"], "/a \"b\"/libx.so");
        assert_eq!(json["file_format_version"], "1.0.0");
    }

    #[test]
    fn another_driver_is_not_taken_for_it() {
        assert!(is_ours("SwiftShader Device (Subzero) (Vulkan, )"));
        assert!(
            !is_ours("llvmpipe (LLVM 15.0.6, 256 bits) (Vulkan, Mesa 22.3.6)") && !is_ours("none")
        );
    }
}
