//! An image of each cause of error: the mask, and its errors next to it.

use anyhow::Result;
use std::path::Path;
use umbrage::{ShadowTechnique as _, cpu::Cpu, glam::UVec2, metrics::attribute};
use umbrage_examples::{judge::JudgedScene, sheet::Sheet};
use umbrage_lab::{causes::faults, output::png};
use umbrage_plan::truth::TruthOptions;

const SIZE: UVec2 = UVec2::new(320, 180);

pub(crate) fn write(file: &Path) -> Result<()> {
    let mut sheet = Sheet::new(2);
    for fault in faults() {
        let judged = JudgedScene::by_argument(fault.scene, Some(SIZE), &TruthOptions::default())?;
        let technique = &fault.technique;
        let mask = judged.render(&mut Cpu::new(), technique)?.mask;
        let truth = &judged.truth;
        let causes = attribute(&mask, &truth.image()?)?;
        sheet.push_png(&png::mask(SIZE, &mask, &truth.pixels)?)?;
        sheet.push_png(&png::causes(truth, &causes)?)?;
        let (name, settings) = (technique.name(), technique.settings());
        println!("{}: {name} ({settings}): {:?}", fault.scene, fault.cause);
    }
    sheet.save(file)
}
