"""The desktop editor; installed as `kogao_app`."""
