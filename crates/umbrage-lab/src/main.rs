//! The commands as a standalone program: `umbrage compare model.obj`.

fn main() -> std::process::ExitCode {
    umbrage_lab::cli::Program::default().run()
}
