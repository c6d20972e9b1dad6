//! Registries: enums of named items, in which each variant is one row of properties.

/// An enum of named items.
pub trait Listed: Copy + Send + Sync + 'static {
    /// All items, in the order of lists and figures.
    const ALL: &'static [Self];

    /// Name on the command line and in files.
    fn name(self) -> &'static str;

    /// Description in one phrase.
    fn help(self) -> &'static str;
}

/// Declares the enum `$id` with one variant per row, in the order of lists, help texts and figures.
///
/// A row is a constant of type `$row` with the fields `name` (command line, files), `label` (report) and `help` (command line). The enum implements [`Listed`],
/// and is serialised as its name. A new item needs its own file and one line in the macro call.
#[macro_export]
macro_rules! registry {
    ($(#[$doc:meta])* $id:ident: $row:ty { $($(#[$about:meta])* $variant:ident => $value:expr),+ $(,)? }) => {
        $(#[$doc])*
        #[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
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

        impl $crate::registry::Listed for $id {
            const ALL: &'static [$id] = $id::ALL;

            fn name(self) -> &'static str {
                $id::name(self)
            }

            fn help(self) -> &'static str {
                $id::help(self)
            }
        }

        impl serde::Serialize for $id {
            fn serialize<S: serde::Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
                serializer.serialize_str(self.name())
            }
        }

        impl<'de> serde::Deserialize<'de> for $id {
            fn deserialize<D: serde::Deserializer<'de>>(deserializer: D) -> Result<$id, D::Error> {
                let name = <String as serde::Deserialize>::deserialize(deserializer)?;
                let found = $id::ALL.iter().copied().find(|id| id.name() == name);
                found.ok_or_else(|| serde::de::Error::custom(format!("no {} is called `{name}`", stringify!($id))))
            }
        }
    };
}
