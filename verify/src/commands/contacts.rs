//! The contacts given on the command line, at nodes or at positions along a plate.

use crate::commands::prelude::*;
use clap::{Arg, ArgAction, ArgMatches, Args, Command, FromArgMatches};
use finray_model::sensor::{ContactSpec, DirectionSpec, SensorContacts};

const AT_NODES: &str = "contact";
const AT_POSITIONS: &str = "contact-at";

/// Values of `--contact` and `--contact-at` in the order in which they stand on the command line. Clap's derive macro keeps the order of values only
/// within each option.
pub struct Contacts(Vec<ContactSpec>);

impl Contacts {
    /// Combines the contacts with a scene, as [`SensorContacts::from_specs`] does.
    ///
    /// # Errors
    /// [`Failure::BadInput`] if the contacts contradict each other or the scene.
    pub fn of(&self, scene: &Scene, friction: f64, measured_deg: Option<f64>) -> Result<SensorContacts, Failure> {
        SensorContacts::from_specs(&self.0, scene, friction, measured_deg).map_err(bad_input)
    }

    /// Whether any contact of unknown position is given without a direction; its force is then assumed along the undeformed normal.
    pub fn assume_normal(&self) -> bool {
        self.0.iter().any(|asked| asked.position.is_none() && !asked.is_direction_given)
    }

    /// Whether the position of any contact is to be estimated.
    pub fn ask_position(&self) -> bool {
        self.0.iter().any(|asked| asked.position.is_none())
    }

    /// Number of contacts.
    pub fn count(&self) -> usize {
        self.0.len()
    }

    /// Whether any contact has the direction `measured`.
    pub fn ask_measured(&self) -> bool {
        self.0.iter().any(|asked| asked.direction == DirectionSpec::Measured)
    }
}

impl Args for Contacts {
    fn augment_args(command: Command) -> Command {
        let list = |name| Arg::new(name).long(name).num_args(1..).action(ArgAction::Append);
        // Networks are trained for known contacts, and a stream has no measured forces.
        let [node, place] = match command.get_name() {
            "train" => ["NODE[@ANGLE_DEG]", "S_MM[@ANGLE_DEG]"],
            "live" => [
                "NODE[@ANGLE_DEG[+-SD]|normal|friction|object|auto]",
                "S_MM[+-SD]|auto[@ANGLE_DEG[+-SD]|normal|friction|object|auto]",
            ],
            _ => [
                "NODE[@ANGLE_DEG[+-SD]|normal|friction|object|measured|auto]",
                "S_MM[+-SD]|auto[@ANGLE_DEG[+-SD]|normal|friction|object|measured|auto]",
            ],
        };
        let place_help = match command.get_name() {
            "train" => "Contact at mm from the base along the front plate, or with back:S_MM along the back plate",
            _ => "Contact at mm from the base: S_MM front plate, back:S_MM back plate, auto: unknown (front)",
        };
        command
            .arg(
                list(AT_NODES)
                    .value_name(node)
                    .value_parser(ContactSpec::at_node)
                    .help("Contact at a node of the front plate, tip included"),
            )
            .arg(list(AT_POSITIONS).value_name(place).value_parser(ContactSpec::at_position).help(place_help))
    }

    fn augment_args_for_update(command: Command) -> Command {
        Contacts::augment_args(command)
    }
}

impl FromArgMatches for Contacts {
    fn from_arg_matches(matches: &ArgMatches) -> Result<Contacts, clap::Error> {
        let positions_and_values = |name| {
            let positions = matches.indices_of(name).into_iter().flatten();
            positions.zip(matches.get_many::<ContactSpec>(name).into_iter().flatten().copied())
        };
        let mut contacts: Vec<_> = positions_and_values(AT_NODES).chain(positions_and_values(AT_POSITIONS)).collect();
        contacts.sort_by_key(|(position, _)| *position);
        Ok(Contacts(contacts.into_iter().map(|(_, contact)| contact).collect()))
    }

    fn update_from_arg_matches(&mut self, matches: &ArgMatches) -> Result<(), clap::Error> {
        *self = Contacts::from_arg_matches(matches)?;
        Ok(())
    }
}
