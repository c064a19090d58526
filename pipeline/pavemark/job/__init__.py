"""The job: from a job file to a finished dataset, by workers that can be stopped, killed and started again."""
