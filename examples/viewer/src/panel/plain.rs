//! Settings as plain data: this program displays all settings of a technique and its map without a
//! list of their names.

use super::side::labelled_drag;
use toml::{Table, Value};
use umbrage::techniques::TechniquePreset;

/// The key of a preset's map.
const MAP: &str = "map";
/// Settings of the map that have other controls.
const ELSEWHERE: [&str; 3] = ["size", "fit", "layout"];
/// The kind of layout with cascades. Their number has another control.
const CASCADES: &str = "cascades";
const COUNT: &str = "count";

/// Shows the settings of a technique except its map. Returns the technique with the user's changes.
pub(super) fn own(ui: &mut egui::Ui, preset: &TechniquePreset) -> Option<TechniquePreset> {
    let table: Table = preset.to_toml().ok()?.parse().ok()?;
    let mut changed = table.clone();
    for (name, value) in &mut changed {
        if name != MAP && name != "technique" {
            setting(ui, &table, &[name], value);
        }
    }
    changed_preset(&table, &changed)
}

/// Shows the settings of a technique's map except its size, fit and number of layers. Returns the
/// technique with the user's changes.
pub(super) fn of_map(ui: &mut egui::Ui, preset: &TechniquePreset) -> Option<TechniquePreset> {
    let table: Table = preset.to_toml().ok()?.parse().ok()?;
    let mut changed = table.clone();
    let map = changed.get_mut(MAP)?.as_table_mut()?;
    for (name, value) in map.iter_mut() {
        if !ELSEWHERE.contains(&name.as_str()) {
            setting(ui, &table, &[MAP, name], value);
        }
    }
    let layout = map.get_mut("layout").and_then(Value::as_table_mut);
    let cascades = layout.and_then(|layout| layout.get_mut(CASCADES)?.as_table_mut());
    if let Some(cascades) = cascades {
        ui.weak(CASCADES);
        for (name, value) in cascades.iter_mut().filter(|(name, _)| *name != COUNT) {
            setting(ui, &table, &[MAP, "layout", CASCADES, name], value);
        }
    }
    changed_preset(&table, &changed)
}

/// Returns the preset if the user changed it, and its reader accepts it.
fn changed_preset(before: &Table, after: &Table) -> Option<TechniquePreset> {
    if before == after {
        return None;
    }
    TechniquePreset::from_toml(&toml::to_string(after).ok()?).ok()
}

/// Shows a value, and the values in it. `preset` has all settings, and `path` is the value's path
/// in them.
fn setting(ui: &mut egui::Ui, preset: &Table, path: &[&str], value: &mut Value) {
    let label = path
        .last()
        .map_or(String::new(), |name| name.replace('_', " "));
    match value {
        Value::Integer(number) => {
            let drag = egui::DragValue::new(number).range(0..=1024).speed(0.1);
            labelled_drag(ui, drag, &label);
        }
        Value::Float(number) => {
            let speed = (0.01 * number.abs()).max(1e-4);
            let drag = egui::DragValue::new(number)
                .range(0.0..=64.0)
                .speed(speed)
                .max_decimals(5);
            labelled_drag(ui, drag, &label);
        }
        Value::Boolean(is_on) => {
            ui.checkbox(is_on, label);
        }
        Value::String(word) => {
            egui::ComboBox::from_label(label)
                .selected_text(word.clone())
                .show_ui(ui, |ui| {
                    for choice in taken_choices(preset, path) {
                        let shown = choice.clone();
                        ui.selectable_value(word, choice, shown);
                    }
                });
        }
        Value::Table(table) => {
            egui::CollapsingHeader::new(label).show(ui, |ui| {
                for (name, value) in table.iter_mut() {
                    setting(ui, preset, &[path, &[name]].concat(), value);
                }
            });
        }
        Value::Array(_) | Value::Datetime(_) => {}
    }
}

/// Returns the valid words at a path of a preset, except those that need further values.
fn taken_choices(preset: &Table, path: &[&str]) -> Vec<String> {
    let mut words = choices(preset, path);
    words.retain(|word| {
        with_word(preset, path, word).is_some_and(|text| TechniquePreset::from_toml(&text).is_ok())
    });
    words
}

/// Returns the text of a preset with a word at a path, if the preset has such a path.
fn with_word(preset: &Table, path: &[&str], word: &str) -> Option<String> {
    let (last, tables) = path.split_last()?;
    let mut changed = preset.clone();
    let mut table = &mut changed;
    for name in tables {
        table = table.get_mut(*name)?.as_table_mut()?;
    }
    table.insert((*last).to_owned(), word.into());
    toml::to_string(&changed).ok()
}

/// Returns the words that the preset reader expects at a path. It lists them in its error for an
/// unknown word.
fn choices(preset: &Table, path: &[&str]) -> Vec<String> {
    // Not an identifier of Rust, and therefore in no list of words.
    const UNKNOWN: &str = "-";
    let Some(text) = with_word(preset, path, UNKNOWN) else {
        return Vec::new();
    };
    let Err(error) = TechniquePreset::from_toml(&text) else {
        return Vec::new();
    };
    let words = error.to_string();
    let Some((_, list)) = words.split_once("expected") else {
        return Vec::new();
    };
    // In `expected one of `a`, `b``, every other part is in quotes. Further lines are help.
    let list = list.lines().next().unwrap_or_default();
    let quoted = list.split('`').skip(1).step_by(2);
    quoted.map(str::to_owned).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use umbrage::techniques;

    /// Calls a function with each word of a table and its path.
    fn words(table: &Table, path: &[&str], visit: &mut dyn FnMut(&[&str], &str)) {
        for (name, value) in table {
            let path = [path, &[name.as_str()]].concat();
            match value {
                Value::String(word) => visit(&path, word),
                Value::Table(inner) => words(inner, &path, visit),
                _ => {}
            }
        }
    }

    /// Shows a map's settings without user input.
    fn show_preset(preset: &TechniquePreset) -> Option<TechniquePreset> {
        let mut changed = None;
        let context = egui::Context::default();
        let mut output = context.run_ui(egui::RawInput::default(), |ui| {
            changed = of_map(ui, preset);
        });
        // Clear textures, which panic if dropped without being drawn.
        output.textures_delta.clear();
        changed
    }

    #[test]
    fn what_is_only_shown_stays_as_it_is() {
        // Beyond the range of dragging.
        let far = "technique = 'pcf'\n[map.layout.cascades]\ncount = 3\nnearest = 1000.0\n";
        let preset = TechniquePreset::from_toml(far).expect("a preset");
        assert_eq!(show_preset(&preset), None);
    }

    #[test]
    fn words_of_all_techniques_have_choices_and_none_is_left_out_but_with_numbers() {
        let mut found = 0;
        let presets = techniques::all().iter().map(|entry| (entry.preset)());
        let cascades = "technique = 'pcf'\n[map.layout.cascades]\ncount = 3\n";
        let cascades = TechniquePreset::from_toml(cascades).expect("a preset");
        for preset in presets.chain([cascades]) {
            let name = preset.technique().name();
            let text = preset.to_toml().expect("written");
            let table: Table = text.parse().expect("a table");
            words(&table, &[], &mut |path, word| {
                if path == ["technique"] || path == [MAP, "fit"] || path == [MAP, "layout"] {
                    return;
                }
                let known = taken_choices(&table, path);
                assert!(
                    known.iter().any(|choice| choice == word),
                    "{}: {path:?}: {known:?}",
                    name
                );
                assert!(known.len() > 1, "{}: {path:?}: {known:?}", name);
                let listed = choices(&table, path);
                let left_out: Vec<&String> =
                    listed.iter().filter(|word| !known.contains(word)).collect();
                // These words need further numbers.
                let with_numbers: &[&str] = match path.last() {
                    Some(&"split") => &["practical", "given"],
                    _ => &[],
                };
                assert_eq!(left_out, with_numbers, "{name}: {path:?}");
                found += 1;
            });
        }
        assert!(found > 20, "{found} words");
    }
}
