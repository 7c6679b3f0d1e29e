"""Views: one blueprint for each topic, with its routes."""
