"""What the panel knows of a scene: groups of properties that mirror the records of Pavemark."""
