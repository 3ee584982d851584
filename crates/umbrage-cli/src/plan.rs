//! `plan`: plans the technique for a scene within bounds, prints the reasons, and writes the preset.

use crate::program::Program;
use crate::{
    args::{PlanArguments, PlanBackend},
    usage::Usage,
};
use crate::{
    inputs,
    planning::{self, Progress},
};
use anyhow::{Result, bail};
use comfy_table::{CellAlignment, ContentArrangement, Table, presets::UTF8_FULL_CONDENSED};
use std::path::Path;
use umbrage_core::glam::UVec2;
use umbrage_lab::plan_files::write;
use umbrage_plan::{Bounds, Plan, PlanOptions, Setting, cost::CostModel, plan as find};

/// Plans, prints and writes; errors if nothing is within the bounds.
pub(crate) fn plan(program: &Program, arguments: &PlanArguments) -> Result<()> {
    let [name] = &arguments.scenes[..] else {
        return Err(
            Usage("plan one scene at a time: give one SCENE, or --regret".to_owned()).into(),
        );
    };
    let bounds = Bounds {
        max_error: arguments.max_error,
        max_ms: arguments.max_ms,
        max_bytes: arguments.max_bytes,
    };
    bounds.validate().map_err(|_| {
        Usage("give --max-error, --max-time or --max-bytes, or some of them".to_owned())
    })?;
    let scene = inputs::scene(program, name)?;
    let options = options_of(program, arguments)?;
    let progress = Progress::new();
    let plan = find(&scene, &bounds, &options, &|step| progress.note(step));
    progress.finish();
    let plan = plan?;
    let files = write(&plan, &program.folder(arguments.out.as_deref(), "plan"))?;
    print(&plan, kind(arguments), arguments.prices.as_deref());
    println!();
    for file in &files {
        println!("{}: {}", file.what, file.path.display());
    }
    match plan.preset() {
        Ok(_) => Ok(()),
        Err(miss) => bail!("{miss}"),
    }
}

/// Returns the kind of backend whose prices count.
fn kind(arguments: &PlanArguments) -> &'static str {
    match arguments.backend {
        PlanBackend::Cpu => "cpu",
        PlanBackend::Wgpu => "wgpu",
    }
}

pub(crate) fn options_of(program: &Program, arguments: &PlanArguments) -> Result<PlanOptions> {
    let prices = inputs::prices(arguments.prices.as_deref())?;
    Ok(PlanOptions {
        registry: program.techniques.clone(),
        samples: arguments.samples,
        seed: arguments.seed,
        cost: prices.of(kind(arguments)),
        // The command counts lights from 1.
        light: usize::from(arguments.light) - 1,
        size: arguments.size.map(UVec2::from_array),
        ..PlanOptions::default()
    })
}

/// `prices` is the file of prices, if they aren't the built-in ones.
fn print(plan: &Plan, kind: &str, prices: Option<&Path>) {
    let [w, h] = plan.size;
    let s = &plan.sampled;
    println!(
        "{}: {} light, {w} x {h}, {}",
        plan.scene, plan.light, plan.bounds
    );
    println!(
        "{} receivers sampled in {:.1} s, {} settings tried in {:.1} s (truth of {} receivers in all)\n",
        s.receivers, s.looking, s.settings, s.trying, s.traced
    );
    if let Some(chosen) = &plan.chosen {
        println!("{}", chosen.label());
        let e = &chosen.estimate;
        println!(
            "  error {:.4} ({:.4} to {:.4}, 9 in 10), of which too dark {:.4}, too light {:.4}",
            e.error, e.low, e.high, e.too_dark, e.too_light
        );
        let ms = chosen.milliseconds;
        let by = match prices {
            Some(path) => format!("by the prices of `{}`", path.display()),
            None => {
                let factor = CostModel::factor_of_nine_in_ten(kind);
                format!("on the reference machine within x{factor}, 9 in 10")
            }
        };
        let bytes = planning::bytes(chosen.bytes);
        println!("  {ms:.3} ms predicted ({by}), {bytes}");
    }
    for reason in &plan.reasons {
        println!("  * {reason}");
    }
    if !plan.runners_up.is_empty() {
        println!(
            "\nOthers that nothing tried beats in both error and time:\n{}",
            table(&plan.runners_up)
        );
    }
}

fn table(settings: &[Setting]) -> Table {
    let mut table = Table::new();
    table
        .load_style(UTF8_FULL_CONDENSED)
        .set_content_arrangement(ContentArrangement::Dynamic);
    table.set_header(["technique", "settings", "error", "9 in 10", "ms", "memory"]);
    for s in settings {
        let e = &s.estimate;
        table.add_row([
            s.technique.clone(),
            s.settings.clone(),
            format!("{:.4}", e.error),
            format!("{:.4} to {:.4}", e.low, e.high),
            format!("{:.3}", s.milliseconds),
            planning::bytes(s.bytes),
        ]);
    }
    for column in table.column_iter_mut().skip(2) {
        column.set_cell_alignment(CellAlignment::Right);
    }
    table
}
