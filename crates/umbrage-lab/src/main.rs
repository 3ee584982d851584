//! The commands that measure, as a program of their own: `umbrage compare model.obj`.

fn main() -> std::process::ExitCode {
    umbrage_lab::cli::Program::default().run()
}
