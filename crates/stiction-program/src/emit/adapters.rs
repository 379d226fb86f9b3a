//! Generated files that adapt the C code to Python, LinuxCNC and a bare microcontroller.

use super::SourceFile;
use super::c::C;
use super::tables::kinds;
use std::fmt::Write;

const CTYPES: &str = include_str!("templates/adapters/ctypes.py");
const LINUXCNC: &str = include_str!("templates/adapters/linuxcnc.comp");
const CORTEX_M7: [&str; 2] = [
    include_str!("templates/adapters/cortex_m7.c"),
    include_str!("templates/adapters/cortex_m7.ld"),
];
const RULES: [&str; 3] = [
    include_str!("templates/adapters/ctypes.mk"),
    include_str!("templates/adapters/linuxcnc.mk"),
    include_str!("templates/adapters/cortex_m7.mk"),
];

/// Selection of the environments for which adapter files are generated with the C code.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Adapters {
    /// Python module that calls the C code through `ctypes`.
    pub ctypes: bool,
    /// Component of LinuxCNC's hardware abstraction layer.
    pub linuxcnc: bool,
    /// Self-test on a Cortex-M7 without an operating system, emulated by QEMU.
    pub cortex_m7: bool,
}

impl C<'_> {
    /// Generates the files of the selected adapters. `files` are the source files of the C code.
    pub(super) fn adapters(&self, files: &[SourceFile]) -> Vec<SourceFile> {
        let name = &self.options.name;
        let file = |name: String, text: String| SourceFile { name, text };
        let Adapters { ctypes, linuxcnc, cortex_m7 } = self.options.adapters;
        let mut found = Vec::new();
        if ctypes {
            let mut fields = String::new();
            for kind in kinds(self.program, self.labels) {
                let _ =
                    writeln!(fields, "        (\"{}\", Real * {}),", kind.field, kind.values.len());
            }
            let fingerprint = self.program.fingerprint();
            let halves = format!("{:#010x}, {:#010x}", fingerprint as u32, fingerprint >> 32);
            let more = [("PYTHON_FIELDS", fields), ("PYTHON_FINGERPRINT", halves)];
            let text = self.fill_with(CTYPES, &more);
            found.push(file(format!("{name}.py"), text));
        }
        if linuxcnc {
            found.push(file(format!("{name}_hal.comp"), self.component(files)));
        }
        if cortex_m7 {
            let [start, memory] = CORTEX_M7.map(str::to_owned);
            found.push(file("cortex_m7.c".to_owned(), start));
            found.push(file("cortex_m7.ld".to_owned(), memory));
        }
        found
    }

    /// Generates the makefile rules of the selected adapters.
    pub(super) fn adapter_rules(&self) -> String {
        let Adapters { ctypes, linuxcnc, cortex_m7 } = self.options.adapters;
        let chosen = [ctypes, linuxcnc, cortex_m7].into_iter().zip(RULES);
        chosen.filter(|(is_chosen, _)| *is_chosen).map(|(_, rules)| self.fill(rules)).collect()
    }

    /// Generates the text of the LinuxCNC component, which includes the complete C code.
    fn component(&self, files: &[SourceFile]) -> String {
        let name = &self.options.name;
        let text = |end: &str| {
            let file = files.iter().find(|file| file.name == format!("{name}.{end}"));
            let include = format!("#include \"{name}.h\"\n");
            file.map_or(String::new(), |file| file.text.replace(&include, ""))
        };
        let [mut declared, mut defaults, mut tune] = [const { String::new() }; 3];
        for kind in kinds(self.program, self.labels) {
            let (field, count) = (kind.field, kind.values.len());
            // Loads may change in every cycle, so they are pins. A pin without a signal is zero.
            let is_load = field == "wrench";
            let role = if is_load { "pin in" } else { "param rw" };
            let (about, unit) = (kind.about, kind.unit);
            let _ =
                writeln!(declared, "{role} float tune-{field}-#[{count}] \"{about} ({unit})\";");
            let each = format!("    for (k = 0; k < {count}; ++k) {{\n");
            if !is_load {
                let copy = format!("tune_{field}(k) = all_params.{field}[k];");
                let _ = writeln!(defaults, "{each}        {copy}\n    }}");
            }
            let _ = writeln!(
                tune,
                "{each}        all_params.{field}[k] = (real)tune_{field}(k);\n    }}"
            );
        }
        self.fill_with(
            LINUXCNC,
            &[
                ("HEADER_TEXT", text("h")),
                ("CODE_TEXT", text("c")),
                ("HAL_TUNABLES", declared),
                ("HAL_DEFAULTS", defaults),
                ("HAL_TUNE", tune),
            ],
        )
    }
}
