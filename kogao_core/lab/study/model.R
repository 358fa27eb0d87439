# A mixed model of a study's answers: does "unnatural" follow the distance achieved, and the centre,
# beyond what raters and faces differ in? Run it beside answers.csv: Rscript model.R
# It needs lme4: install.packages("lme4")
library(lme4)

answers <- read.csv("answers.csv")
answers <- subset(answers, counts == 1 & kind == "table1" & !is.na(unnatural))
answers$center <- factor(answers$center)
# About its mean, so that the other coefficients are told at a usual distance.
answers$distance <- answers$achieved_percent - mean(answers$achieved_percent)

fitted <- function(formula) {
  glmer(formula, data = answers, family = binomial,
        control = glmerControl(optimizer = "bobyqa", optCtrl = list(maxfun = 1e5)))
}
# Raters differ in where they begin to call a face unnatural; so do faces.
distance <- fitted(unnatural ~ distance + (1 | rater) + (1 | subject))
print(summary(distance))

b <- fixef(distance)
middle <- mean(answers$achieved_percent) - b[["(Intercept)"]] / b[["distance"]]
# By the delta method.
slope <- c(-1 / b[["distance"]], b[["(Intercept)"]] / b[["distance"]]^2)
error <- sqrt(as.numeric(t(slope) %*% as.matrix(vcov(distance)) %*% slope))
cat(sprintf("50 %% unnatural at %.2f %% of D (95 %%: %.2f to %.2f)\n",
            middle, middle - 1.96 * error, middle + 1.96 * error))

if (nlevels(answers$center) > 1) {
  centre <- fitted(unnatural ~ distance + center + (1 | rater) + (1 | subject))
  print(summary(centre))
  cat("Do centres differ at the same achieved distance?\n")
  print(anova(distance, centre))
}
