//! Registries: enums of named items. Each variant of a registry enum has one row of constant properties.

/// Declares the enum `$id` with one variant per row. Lists, help texts and figures show the variants in the order of the rows.
///
/// A row is a constant of type `$row` with the fields `name` (command line, files), `label` (report) and `help` (command line). Serde writes a
/// variant as its identifier in kebab case. A new item needs its own file and one line in the macro call.
#[macro_export]
macro_rules! registry {
    ($(#[$doc:meta])* $id:ident: $row:ty { $($(#[$about:meta])* $variant:ident => $value:expr),+ $(,)? }) => {
        $(#[$doc])*
        #[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, serde::Serialize, serde::Deserialize)]
        #[serde(rename_all = "kebab-case")]
        pub enum $id { $($(#[$about])* $variant),+ }

        impl $id {
            /// All items, in the order of lists and figures.
            pub const ALL: &[$id] = &[$($id::$variant),+];

            fn row(self) -> &'static $row {
                match self { $($id::$variant => &$value),+ }
            }

            /// Name on the command line and in files.
            pub fn name(self) -> &'static str {
                self.row().name
            }

            /// Name in the report.
            pub fn label(self) -> &'static str {
                self.row().label
            }

            /// Description in one phrase.
            pub fn help(self) -> &'static str {
                self.row().help
            }
        }

        impl std::fmt::Display for $id {
            fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
                f.pad(self.name())
            }
        }

    };
}
